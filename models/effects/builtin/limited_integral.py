"""A controller that integrates its error up to a limit, as most firmware does."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects.builtin import integral_action


def term(
    drive: float, w: float, held: float, rate: float, lag: float, limit: float
) -> tuple[float, float]:
    """Drive [deg] with the torque ``held`` [deg] by the integral, and that state's rate.

    Beyond its limit the state is what the integrator has not yet cut off.
    """
    return drive + min(max(held, -limit), limit), rate * (drive - lag * w)


def rest(missing: float, rate: float, lag: float, limit: float) -> float:
    """What a second of standing still has gathered of the torque that it has to hold."""
    return min(max(missing * (1.0 - math.exp(-rate)), -limit), limit)


def switch(drive: float, w: float, held: float, rate: float, lag: float, limit: float) -> float:
    """Changes sign where the integral reaches its limit, and where it leaves it."""
    if held < limit:
        return held - limit
    return rate * (drive - lag * w)


def second_switch(
    drive: float, w: float, held: float, rate: float, lag: float, limit: float
) -> float:
    """The same of its limit below zero."""
    if held > -limit:
        return held + limit
    return rate * (drive - lag * w)


def resolution(T: float, rate: float, lag: float, limit: float) -> float:
    """Longest step [s] that follows the integral; what it passes its limit by and leaves again
    within one is overlooked."""
    return max(min(0.1 * T, 0.05 / (rate + 1e-12)), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Those without a limit, with half the lag and at limits that act: from one that does not no
    slope leads to one that does."""
    limits = (0.07 * features.drive_deg, 0.03 * features.drive_deg)
    free = integral_action.starts(features)
    return tuple((rate, 0.5 * lag, limit) for limit in limits for rate, lag in free)


EFFECT = Effect(
    id="limited_integral",
    place=Place.DRIVE,
    parameters=(
        *integral_action.EFFECT.parameters,
        Parameter("limit", "deg", 1e-2, math.inf, math.inf, "largest torque held", TORQUE),
    ),
    equation="drive = e + s, ds/dt = rate (e - lag w) while |s| <= limit",
    looks_like="as integral action, but of a large weight or friction an error stays; steps "
    "overshoot alike, whether they are large or very large",
    cause="integral gain of a controller whose integral is limited, against winding up: Feetech's "
    "limit of the integral, IMAX of ArduPilot",
    confirm="set the limit of the integral to its largest value, or the integral gain to zero, and "
    "repeat",
    remedy="none is needed: keep it in the model; a limit above the largest weight and friction "
    "lets no error stay",
    source="Astrom and Hagglund, Advanced PID Control (2006), chapter 3",
    starts=starts,
    term=term,
    rest=rest,
    switch=switch,
    second_switch=second_switch,
    resolution=resolution,
    states=1,
    state_limit="limit",
    contains=("integral_action",),
)
