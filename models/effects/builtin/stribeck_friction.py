"""Dry friction that is larger near rest."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    rate: float, drive: float, load: float, level: float, excess: float, speed: float
) -> float:
    """Size of the friction torque [deg] at ``rate`` [deg/s]; the integrator makes it stick."""
    share = rate * (1.0 / speed)  # a quotient of parameters alone is worked out once
    return level + excess * math.exp(-share * share)


def switch(
    rate: float, drive: float, load: float, level: float, excess: float, speed: float
) -> float:
    """Changes sign where the excess begins to matter: at 3 speeds a ten-thousandth is left."""
    return rate - 3.0 * speed


def resolution(
    T: float, w: float, acceleration: float, level: float, excess: float, speed: float
) -> float:
    """Longest step [s] where friction falls with speed: motion grows there, as stick-slip does."""
    if w > 3.01 * speed:
        return math.inf
    growth = 0.15 * T * T * speed / (excess + 1e-12)
    passage = 0.2 * speed / (acceleration + 1e-12)
    return max(min(growth, passage), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Levels about the residual's size, with as much or twice as much excess, at three speeds."""
    return tuple(
        (
            level * features.residual_deg,
            more * level * features.residual_deg,
            share * features.speed_deg_s,
        )
        for level in (0.5, 1.0, 2.0)
        for more in (0.7, 2.0)
        for share in (0.01, 0.03, 0.1)
    )


EFFECT = Effect(
    id="stribeck_friction",
    place=Place.FRICTION,
    parameters=(
        Parameter("level", "deg", 0.0, 90.0, 0.0, "friction at speed", TORQUE),
        Parameter("excess", "deg", 0.0, 90.0, 0.0, "additional friction at rest", TORQUE),
        Parameter("speed", "deg/s", 0.1, 1000.0, None, "speed at which e^-1 of the excess is left"),
    ),
    equation="friction = (level + excess exp(-(w / speed)^2)) sign(w); sticks while "
    "|drive - load| <= level + excess",
    looks_like="slow motion is jerky: it sticks, jumps and sticks again, while faster motion "
    "is smooth; the breakaway torque exceeds what keeps it moving",
    cause="lubricated gears and bearings, seals after a rest",
    confirm="creep the command at 1, 5 and 20 deg/s: the jerks vanish above one speed; the torque "
    "to start is larger than the torque to keep moving",
    remedy="another grease, less preload, dither, or keep away from creeping motion",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30(7) (1994), eq. 4",
    starts=starts,
    term=term,
    switch=switch,
    resolution=resolution,
    contains=("coulomb_friction",),
)
