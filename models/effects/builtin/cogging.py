"""Torque that goes up and down with the angle."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._wave import wave_resolution, wave_starts


def term(theta: float, w: float, amplitude: float, period: float, phase: float) -> float:
    """Torque [deg] at ``theta`` [deg]."""
    return amplitude * math.sin(6.283185307179586 / period * theta + phase)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The strongest lines in the residual's spectrum over angle."""
    return wave_starts(features, 180.0)


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
    remedy="a skewed or slotless motor, better gears, feedforward of the torque from a table",
    source="Hanselman, Brushless Permanent Magnet Motor Design (2006), chapter 10; same form as "
    "MuJoCo's dcmotor cogging",
    starts=starts,
    term=term,
    resolution=wave_resolution,
)
