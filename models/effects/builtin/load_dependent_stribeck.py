"""Friction in proportion to the torque that the gears transmit, which vanishes with speed."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    rate: float, drive: float, load: float, excess: float, speed: float, back_emf: float
) -> float:
    """Size of the friction torque [deg] at ``rate`` [deg/s]: a share of what the gears transmit.

    That is the drive less what back-EMF takes of it at this speed, and the load: where the motor
    carries the load, both have one sign.
    """
    share = rate * (1.0 / speed)  # a quotient of parameters alone is worked out once
    return excess * math.exp(-share * share) * abs(drive - back_emf * rate + load)


def switch(
    rate: float, drive: float, load: float, excess: float, speed: float, back_emf: float
) -> float:
    """Changes sign where the excess begins to matter: at 3 speeds a ten-thousandth is left."""
    return rate - 3.0 * speed


def resolution(
    T: float, w: float, acceleration: float, excess: float, speed: float, back_emf: float
) -> float:
    """Longest step [s] where friction falls with speed: motion grows there, as stick-slip does."""
    if w > 3.01 * speed:
        return math.inf
    if w + T * acceleration < 1e-3 * speed:
        return 0.08 * T  # it creeps towards rest, and may do so for seconds
    growth = 0.3 * T * T * speed / (30.0 * excess + 1e-12)  # under a large torque of 30 deg
    passage = 0.2 * speed / (acceleration + 1e-12)
    return max(min(growth, passage), 0.025 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """A third and a tenth of the torque, at two speeds; damping by back-EMF."""
    return tuple(
        (excess, share * features.speed_deg_s, features.T_s)
        for excess in (0.3, 0.1)
        for share in (0.4, 0.1)
    )


EFFECT = Effect(
    id="load_dependent_stribeck",
    place=Place.FRICTION,
    parameters=(
        Parameter(
            "excess", "-", 0.0, 0.98, 0.0, "friction at rest for each unit of transmitted torque"
        ),
        Parameter("speed", "deg/s", 0.1, 1000.0, None, "speed at which e^-1 of the excess is left"),
        Parameter(
            "back_emf", "s", 0.0, 2.0, None, "torque that back-EMF takes for each deg/s", TORQUE
        ),
    ),
    equation="friction = excess exp(-(w / speed)^2) |drive - back_emf w + load| sign(w)",
    looks_like="under a load it sticks and starts with a jerk, the more so the heavier the load; "
    "fast motion and motion without a load are smooth",
    cause="tooth flanks whose film of grease carries load at speed alone",
    confirm="hang two weights on the surface and creep the command: the torque to start grows with "
    "the weight, and falls once it moves",
    remedy="another grease, a lower ratio, balance the load, or keep away from creeping motion",
    source="Duclusaud et al., BAM: extended friction models (2024), model m4",
    starts=starts,
    term=term,
    switch=switch,
    resolution=resolution,
)
