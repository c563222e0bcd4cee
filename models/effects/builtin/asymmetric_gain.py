"""Drive of another strength in one direction."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import one


def term(drive: float, w: float, ratio: float) -> float:
    """Negative drive [deg] times ``ratio``."""
    if drive < 0.0:
        return ratio * drive
    return drive


def switch(drive: float, w: float, ratio: float) -> float:
    """Changes sign with the drive."""
    return drive


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """As the residual says, and clearly weaker and clearly stronger."""
    lost = one(features.curves, np.minimum(features.curves.drive_deg, 0.0))
    return ((1.0 - min(max(lost, -4.0), 0.8),), (0.6,), (1.6,)) if lost else ((0.6,), (1.6,))


EFFECT = Effect(
    id="asymmetric_gain",
    place=Place.DRIVE,
    parameters=(Parameter("ratio", "-", 0.05, 20.0, 1.0, "negative drive over positive drive"),),
    equation="drive = e where e > 0, ratio e where e < 0",
    looks_like="steps one way are faster than the same steps back, at all amplitudes, and both end "
    "at the right angle",
    cause="half-bridge whose two sides differ, a motor with advanced timing",
    confirm="swap the motor's leads: the weaker direction changes sides; or compare the first "
    "20 ms of a step up with those of a step down",
    remedy="match the half-bridges, or scale the drive of one direction in the firmware",
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor "
    "Nonlinearities (1996), chapter 2: piecewise-linear characteristics",
    starts=starts,
    term=term,
    switch=switch,
)
