"""The effects of an ordinary servo, which the wider search tries together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.models.effects import Effect, Place, Usual

ORDINARY = (
    "gravity_load",
    "directional_friction",
    "torque_saturation",
    "stribeck_friction",
    "dead_time",
    "rate_limit",
    "load_dependent_stribeck",
    "supply_sag",
    "coulomb_friction",
    "backlash",
    "speed_limit",
    "current_limit",
    "feedback_backlash",
    "dead_band",
    "load_dependent_friction",
    "motion_profile",
)
"""What an ordinary geared servo has; in this order each has what it needs to show before it."""

INTEGRAL_LOOP = ("limited_integral", "current_limit", "gravity_load", "coulomb_friction")
"""What a servo has whose loop integrates its error, the integral first: without that, or without
the limit that it works against, all else is fitted wrong."""

PLAY = ("backlash", "feedback_backlash")
"""The same play behind what the sensor sees and before it: where one is in a model that lacks the
other, it takes up what that would explain."""


def at_several_gains(ordinary: Sequence[str], catalogue: Mapping[str, Effect]) -> tuple[str, ...]:
    """The same with effects ``for_several_gains`` and those that they name in each other's place.

    Load, friction and limits in degrees fall with the gain, and the speed at which the back-EMF
    takes up the voltage does not: recordings at several gains show how a limit falls with speed.
    Without that in the first joint model, all else in it is fitted wrong.

    >>> from servosight.models.effects import catalogue
    >>> at_several_gains(("torque_saturation", "dead_time", "current_limit"), catalogue())
    ('current_limit', 'dead_time', 'torque_saturation')
    """
    places = {name: effect.for_several_gains for name, effect in catalogue.items()}
    other = {name: first for name, first in places.items() if first is not None}
    other |= {first: name for name, first in other.items()}
    return tuple(other.get(name, name) for name in ordinary)


def shapes(ordinary: Sequence[str], catalogue: Mapping[str, Effect]) -> dict[str, str]:
    """The ordinary effects of the command that another one of these contains, and that one.

    >>> from servosight.models.effects import catalogue
    >>> shapes(ORDINARY, catalogue())
    {'rate_limit': 'motion_profile'}
    """
    there = (catalogue[name] for name in ordinary if name in catalogue)
    on_command = [effect for effect in there if effect.place is Place.COMMAND]
    return {name: effect.id for effect in on_command for name in effect.contains}


def usual(catalogue: Mapping[str, Effect], kind: Usual) -> tuple[str, ...]:
    """The effects of the catalogue that every servo has as its weight, or as its friction.

    >>> from servosight.models.effects import catalogue
    >>> usual(catalogue(), Usual.WEIGHT)
    ('gravity_load',)
    """
    return tuple(name for name, effect in catalogue.items() if effect.usual is kind)
