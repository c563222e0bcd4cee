"""A controller that integrates its error, in the position loop or in a speed loop within it."""

from __future__ import annotations

import math

import numpy as np

from servosight.models.core import Parameter, Scaling
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(drive: float, w: float, held: float, rate: float, lag: float) -> tuple[float, float]:
    """Drive [deg] with the torque ``held`` [deg] by the integral, and that state's rate."""
    return drive + held, rate * (drive - lag * w)


def rest(missing: float, rate: float, lag: float) -> float:
    """What a second of standing still has gathered of the torque that it has to hold."""
    return missing * (1.0 - math.exp(-rate))


def resolution(T: float, rate: float, lag: float) -> float:
    """Longest step [s] that follows the integral."""
    return max(min(0.2 * T, 0.1 / (rate + 1e-12)), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Slow and fast, about a loop that lags as this one does on the whole."""
    curves = features.curves
    square = float(np.sum(curves.speed_deg_s**2))
    lag = float(np.sum(curves.drive_deg * curves.speed_deg_s)) / square if square > 0.0 else 0.0
    return tuple((rate, min(max(lag, 0.0), 2.0)) for rate in (3.0, 10.0, 30.0))


EFFECT = Effect(
    id="integral_action",
    place=Place.DRIVE,
    parameters=(
        Parameter("rate", "1/s", 0.0, 500.0, 0.0, "what the integral gathers of an error"),
        Parameter(
            "lag",
            "s",
            0.0,
            2.0,
            None,
            "error left on a ramp, for each deg/s of it",
            Scaling(gain=-1.0),
        ),
    ),
    equation="drive = e + s, ds/dt = rate (e - lag w)",
    looks_like="the error after a reversal or under a load dies away instead of staying; steps "
    "overshoot and creep back; without lag, a ramp is followed without error",
    cause="integral gain of a position controller (PID), or of a speed controller within the "
    "position loop (cascade of industrial drives), for which lag is 1 / Kp of the position loop",
    confirm="set the integral gain to zero and repeat: friction and weight then leave an error "
    "that stays",
    remedy="none is needed: keep it in the model; where steps overshoot, lower the integral gain, "
    "or take the set-point out of its proportional part",
    source="Astrom and Hagglund, Advanced PID Control (2006), chapter 3",
    starts=starts,
    term=term,
    rest=rest,
    resolution=resolution,
    states=1,
    together_with=("coulomb_friction", "velocity_feedforward"),
)
