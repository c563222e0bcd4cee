"""Position sensor whose error goes up and down with the angle."""

from __future__ import annotations

import math

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._wave import wave_resolution, wave_starts


def term(theta: float, amplitude: float, period: float, phase: float) -> float:
    """What the loop believes the angle ``theta`` [deg] to be."""
    return theta + amplitude * math.sin(6.283185307179586 / period * theta + phase)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The strongest lines in the residual's spectrum over angle."""
    return wave_starts(features, 360.0)


EFFECT = Effect(
    id="sensor_nonlinearity",
    place=Place.FEEDBACK,
    parameters=(
        Parameter("amplitude", "deg", 0.0, 45.0, 0.0, "largest error of the sensor"),
        Parameter("period", "deg", 0.5, 360.0, None, "angle after which the error repeats"),
        Parameter(
            "phase", "rad", -math.pi, math.pi, None, "phase at the zero angle", circular=True
        ),
    ),
    equation="feedback = theta + amplitude sin(2 pi theta / period + phase)",
    looks_like="at rest the error depends on the angle and repeats after the period; slow motion "
    "wobbles in the same places; at one loop gain the equation is that of cogging",
    cause="potentiometer, a magnet off the axis of its encoder",
    confirm="raise the loop gain: unlike cogging, the wobble keeps its size; or print the servo's "
    "own angle beside the camera's with the motor off",
    remedy="calibrate the sensor by a table, centre the magnet, a better potentiometer",
    source="Ellis, Control System Design Guide (2012), chapter 14: cyclic error",
    starts=starts,
    term=term,
    resolution=wave_resolution,
)
