"""The loop takes the derivative of the command too: its desired speed."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import one


def term(
    value: float,
    slope: float,
    horizon: float,
    last: float,
    reached: float,
    before: float,
    lead: float,
) -> tuple[float, float, float, float, float]:
    """Add ``lead`` times the desired speed, which a held command has in its jumps.

    The states are the angle that this speed has led to, and the speed by the jump before. A jump
    over the time until the next is the speed half a row ago; so the last two are extrapolated.
    Rows closer than 1 ms are one, and a goal held for more than 32 ms is as many equal ones.
    """
    ahead = value - reached
    if abs(ahead) <= 1e-9 and abs(before) <= 1e-6:
        return value + lead * slope, slope, horizon, slope, 0.0
    row = max(min(horizon, 3.2), 1e-3)
    row = row / math.ceil(row / 3.2e-2)
    speed = ahead / row
    change = (speed - before) / row
    now = slope + 2.0 * speed - before
    return value + lead * now, slope - lead * change, min(horizon, row), slope + speed, change


def rest(value: float, lead: float) -> tuple[float, float]:
    """At the command, without a speed."""
    return value, 0.0


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The time that explains the residual best to first order, where one does; else a short one."""
    curves, T = features.curves, features.T_s
    read = min(-one(curves, curves.k * curves.command_speed_deg_s), 3.0 * T)
    return ((T,), (3.0 * T,), (read,)) if read > 0.0 else ((T,),)


EFFECT = Effect(
    id="velocity_feedforward",
    place=Place.COMMAND,
    parameters=(
        Parameter("lead", "s", 0.0, 0.5, 0.0, "torque for each deg/s of the command", TORQUE),
    ),
    equation="T^2 y'' + 2 xi T y' + y = k (u + lead u')",
    looks_like="fast smooth motion is followed with less lag than the damping allows; a step is "
    "answered with a kick, and overshoots more than the decay that follows explains",
    cause="desired speed sent beside the desired angle and weighted by Kd (AK80, ODrive, moteus), "
    "feed-forward gain in the firmware (Dynamixel), a derivative of the error in the controller, "
    "an integral in a speed loop within the position loop, which has a zero as well",
    confirm="set the desired speed, the feed-forward gain or the derivative of the set-point to "
    "zero and repeat: the lag on a ramp grows by lead",
    remedy="none is needed: keep it in the model; where steps overshoot, take the derivative of "
    "the measured angle alone, or send ramps",
    source="Astrom and Hagglund, Advanced PID Control (2006), chapter 3: set-point weighting",
    starts=starts,
    term=term,
    rest=rest,
    states=2,
    lead="lead",
    least_share=1.0 / 3.0,
)
