"""Friction in proportion to the torque that the reducer transmits."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place, Usual


def term(speed: float, drive: float, load: float, ratio: float) -> float:
    """Size of the friction torque [deg] from the torque at the motor's side of the gears."""
    return ratio * abs(drive)


def switch(speed: float, drive: float, load: float, ratio: float) -> float:
    """Changes sign with the drive, where the size has its corner."""
    return drive


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """A tenth, a third and two thirds of the transmitted torque."""
    return ((0.08,), (0.25,), (0.6,))


EFFECT = Effect(
    id="load_dependent_friction",
    place=Place.FRICTION,
    parameters=(
        Parameter("ratio", "-", 0.0, 0.98, 0.0, "friction for each unit of transmitted torque"),
    ),
    equation="friction = ratio |transmitted torque| sign(w)",
    looks_like="acceleration is weaker than deceleration at all amplitudes; the harder the servo "
    "works, the more it loses; nearly none at small errors",
    cause="worm or high-ratio gears, whose tooth pressure grows with torque",
    confirm="hang a weight on the surface: the torque needed to lift exceeds the one to lower by "
    "more than twice the unloaded friction",
    remedy="better gears or grease, a lower ratio, balance the load",
    source="Duclusaud et al., BAM: extended friction models (2024), model m3",
    starts=starts,
    term=term,
    switch=switch,
    usual=Usual.FRICTION,
)
