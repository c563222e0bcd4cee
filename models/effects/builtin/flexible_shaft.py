"""Second inertia behind a spring."""

from __future__ import annotations

import math

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    theta: float,
    w: float,
    T: float,
    far_theta: float,
    far_w: float,
    frequency: float,
    damping: float,
    inertia_ratio: float,
) -> tuple[float, float, float, float]:
    """Reaction on the motor [deg], share of the inertia, and rates of the far side's state."""
    omega = 6.283185307179586 * frequency
    acceleration = omega * (omega * (theta - far_theta) + 2.0 * damping * (w - far_w))
    return inertia_ratio * T * T * acceleration, inertia_ratio, far_w, acceleration


def resolution(frequency: float, damping: float, inertia_ratio: float) -> float:
    """Longest step [s] that follows the spring: a sixteenth of a cycle with the motor free."""
    return 0.064 * math.sqrt(1.0 - inertia_ratio) / (frequency * (1.0 + 2.0 * damping))


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Below, at and above the corner of the linear loop, light and heavy far side."""
    corner = 1.0 / (6.283185307179586 * features.T_s)
    return ((1.5 * corner, 0.1, 0.3), (3.0 * corner, 0.1, 0.3), (0.7 * corner, 0.1, 0.1))


EFFECT = Effect(
    id="flexible_shaft",
    place=Place.SHAFT,
    parameters=(
        Parameter("frequency", "Hz", 2.0, 150.0, float("inf"), "resonance with the motor locked"),
        Parameter("damping", "-", 0.0, 1.0, None, "damping ratio of that resonance"),
        Parameter("inertia_ratio", "-", 0.0, 0.8, None, "far inertia over the total"),
    ),
    equation="far'' = (2 pi frequency)^2 (theta - far) + 2 damping (2 pi frequency) (w - far'); "
    "the motor carries 1 - inertia_ratio of T^2 and the spring's reaction",
    looks_like="ringing after steps at a frequency of its own, a peak in the frequency response "
    "and a phase that falls by another 180 deg",
    cause="thin shaft, long pushrod, soft surface",
    confirm="hold the servo still and tap the surface: it rings at the frequency",
    remedy="stiffen the linkage, lighten the surface, or a notch filter on the command",
    source="Ellis, Control System Design Guide (2012), chapter 16: compliant coupling",
    starts=starts,
    term=term,
    resolution=resolution,
    states=2,
)
