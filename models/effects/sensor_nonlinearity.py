"""Position sensor whose error goes up and down with the angle."""

from __future__ import annotations

import math

from servosight.models.effect import Cues, Effect, Place
from servosight.models.parameter import Parameter
from servosight.models.readings import waves


def term(theta: float, amplitude: float, period: float, phase: float) -> float:
    """What the loop believes the angle ``theta`` [deg] to be."""
    return theta + amplitude * math.sin(6.283185307179586 * theta / period + phase)


def resolution(
    T: float, w: float, acceleration: float, amplitude: float, period: float, phase: float
) -> float:
    """Longest step [s]: a tenth of a period's way, and of the swing where the loop is stiffest."""
    way = 0.1 * period
    passage = 2.0 * way / (w + math.sqrt(w * w + 2.0 * acceleration * way) + 1e-12)
    swing = 0.4 * T / math.sqrt(1.0 + 6.283185307179586 * abs(amplitude) / period)
    return max(min(passage, swing), 0.01 * T)


def starts(cues: Cues) -> tuple[tuple[float, ...], ...]:
    """The strongest lines in the residual's spectrum over angle."""
    size, range_deg = cues.residual_deg, 2.0 * cues.amplitude_deg
    read = waves(cues.traces, 0.5, 360.0, 0.02 * cues.drive_deg)
    return read or ((2.0 * size, 0.2 * range_deg, 0.0), (2.0 * size, 0.5 * range_deg, 0.0))


EFFECT = Effect(
    id="sensor_nonlinearity",
    place=Place.FEEDBACK,
    parameters=(
        Parameter("amplitude", "deg", 0.0, 45.0, 0.0, "largest error of the sensor"),
        Parameter("period", "deg", 0.5, 720.0, None, "angle after which the error repeats"),
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
    resolution=resolution,
)
