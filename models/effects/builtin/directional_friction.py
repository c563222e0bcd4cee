"""Friction in proportion to the torques at both ends of the gears, with a share for each."""

from __future__ import annotations

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    speed: float, drive: float, load: float, motor: float, outer: float, back_emf: float
) -> float:
    """Size of the friction torque [deg] from the torques of the motor and of the load.

    The motor brings the drive less what back-EMF takes of it at this speed. Where it carries the
    load, both have one sign and their shares add; where the load drives the motor against its
    torque, they subtract.
    """
    return abs(motor * (drive - back_emf * speed) + outer * load)


def switch(
    speed: float, drive: float, load: float, motor: float, outer: float, back_emf: float
) -> float:
    """Changes sign where the size has its corner."""
    return motor * (drive - back_emf * speed) + outer * load


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The two sides alike, and most of it on one of them; damping mostly by back-EMF, or not."""
    T = features.T_s
    return ((0.12, 0.12, T), (0.12, 0.12, 0.0), (0.3, 0.05, T), (0.05, 0.3, 0.0), (0.3, 0.3, T))


EFFECT = Effect(
    id="directional_friction",
    place=Place.FRICTION,
    parameters=(
        Parameter("motor", "-", 0.0, 0.98, 0.0, "friction for each unit of the motor's torque"),
        Parameter("outer", "-", 0.0, 2.0, 0.0, "friction for each unit of the load's torque"),
        Parameter(
            "back_emf", "s", 0.0, 2.0, None, "torque that back-EMF takes for each deg/s", TORQUE
        ),
    ),
    equation="friction = |motor (drive - back_emf w) + outer load| sign(w)",
    looks_like="under a load it loses another share of the torque while it lifts than while it "
    "lowers or brakes: no single share suits both; in fast motion it loses less than at rest",
    cause="worm or high-ratio gears, whose efficiency differs with the side that drives",
    confirm="hang a weight on the surface and read the current while it lifts, holds and lowers; "
    "repeat with another weight: both differences grow with the weight, at different rates",
    remedy="better gears or grease, a lower ratio, balance the load",
    source="Duclusaud et al., BAM: extended friction models (2024), model m5",
    starts=starts,
    term=term,
    switch=switch,
    contains=("load_dependent_friction",),
)
