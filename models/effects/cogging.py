"""Torque that goes up and down with the angle."""

from __future__ import annotations

import math

from servosight.models.effect import Cues, Effect, Place
from servosight.models.parameter import TORQUE, Parameter
from servosight.models.readings import waves


def term(theta: float, w: float, amplitude: float, period: float, phase: float) -> float:
    """Torque [deg] at ``theta`` [deg]."""
    return amplitude * math.sin(6.283185307179586 * theta / period + phase)


def resolution(
    T: float, w: float, acceleration: float, amplitude: float, period: float, phase: float
) -> float:
    """Longest step [s]: a tenth of a period's way, and of the swing in a detent."""
    way = 0.1 * period
    passage = 2.0 * way / (w + math.sqrt(w * w + 2.0 * acceleration * way) + 1e-12)
    swing = 0.4 * T / math.sqrt(1.0 + 6.283185307179586 * abs(amplitude) / period)
    return max(min(passage, swing), 0.01 * T)


def starts(cues: Cues) -> tuple[tuple[float, ...], ...]:
    """The strongest lines in the residual's spectrum over angle."""
    size, range_deg = cues.residual_deg, 2.0 * cues.amplitude_deg
    read = waves(cues.traces, 0.5, 180.0, 0.02 * cues.drive_deg)
    return read or ((2.0 * size, 0.2 * range_deg, 0.0), (2.0 * size, 0.5 * range_deg, 0.0))


EFFECT = Effect(
    id="cogging",
    place=Place.LOAD,
    parameters=(
        Parameter("amplitude", "deg", 0.0, 90.0, 0.0, "largest torque", TORQUE),
        Parameter("period", "deg", 0.5, 180.0, None, "angle from one detent to the next"),
        Parameter(
            "phase", "rad", -math.pi, math.pi, None, "phase at the zero angle", circular=True
        ),
    ),
    equation="load = amplitude sin(2 pi theta / period + phase)",
    looks_like="slow motion wobbles with the angle, the same at every pass and in both directions; "
    "at rest the error depends on the angle and repeats after the period",
    cause="poles of the motor through the gear, teeth that mesh badly, a bent shaft",
    confirm="switch the servo off and turn the surface by hand: detents at the period; against a "
    "sensor's error: the wobble shrinks as the loop gain rises",
    remedy="a skewed or slotless motor, better gears, a table of the torque fed forward",
    source="Hanselman, Brushless Permanent Magnet Motor Design (2006), chapter 10; same form as "
    "MuJoCo's dcmotor cogging",
    starts=starts,
    term=term,
    resolution=resolution,
)
