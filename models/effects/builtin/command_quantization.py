"""Rounding of the command to whole steps."""

from __future__ import annotations

import math

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import quantization_steps


def term(
    value: float, slope: float, horizon: float, last: float, step: float
) -> tuple[float, float, float]:
    """Round to the nearest multiple of ``step`` [deg]; a slope becomes a staircase."""
    exact = value / step + 0.5
    if slope == 0.0:
        return step * math.floor(exact), 0.0, horizon
    # Within rounding of a riser the command stands where it is heading.
    if slope > 0.0:
        level = float(math.floor(exact + 1e-9))
        riser = (level + 0.5) * step
    else:
        level = math.ceil(exact - 1e-9) - 1.0
        riser = (level - 0.5) * step
    until = (riser - value) / slope
    if until < horizon:
        horizon = until
    return step * level, 0.0, horizon


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The steps whose rounding looks most like the residual; else what makes its size."""
    read = quantization_steps(features.curves, features.residual_deg)
    return read or ((2.0 * features.residual_deg,),)


EFFECT = Effect(
    id="command_quantization",
    place=Place.COMMAND,
    parameters=(
        Parameter(
            "step", "deg", 0.0, 30.0, 0.0, "distance of the command's levels", discontinuous=True
        ),
    ),
    equation="u_q = step round(u / step)",
    looks_like="slow motion is a staircase with steps of one height; at rest the error "
    "is anything up to half a step, and the same command always ends at the same angle",
    cause="coarse pulse-width counter, integer degrees in the protocol",
    confirm="raise the command in steps far below 1 deg: the surface jumps by the same angle each "
    "time, at the same commands on the way up and down",
    remedy="a finer counter or protocol, or a faster update that averages between two levels",
    source="Widrow and Kollar, Quantization Noise (2008), chapter 1",
    starts=starts,
    term=term,
)
