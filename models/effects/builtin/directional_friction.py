"""Friction in proportion to the torques at both ends of the gears, with a share for each."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(speed: float, drive: float, load: float, motor: float, outer: float) -> float:
    """Size of the friction torque [deg] from the torques of the motor and of the load.

    Where the motor carries the load, both have one sign and their shares add; where the load drives
    the motor against its torque, they subtract.
    """
    return abs(motor * drive + outer * load)


def switch(speed: float, drive: float, load: float, motor: float, outer: float) -> float:
    """Changes sign where the size has its corner."""
    return motor * drive + outer * load


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The two sides alike, and most of it on one of them."""
    return ((0.12, 0.12), (0.3, 0.05), (0.05, 0.3), (0.3, 0.3))


EFFECT = Effect(
    id="directional_friction",
    place=Place.FRICTION,
    parameters=(
        Parameter("motor", "-", 0.0, 0.98, 0.0, "friction for each unit of the motor's torque"),
        Parameter("outer", "-", 0.0, 2.0, 0.0, "friction for each unit of the load's torque"),
    ),
    equation="friction = |motor drive + outer load| sign(w)",
    looks_like="under a load it loses another share of the torque while it lifts than while it "
    "lowers or brakes: no single share suits both",
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
