"""The effects of an ordinary servo, which the wider search tries together."""

from __future__ import annotations

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
)
"""What an ordinary geared servo has; in this order each has what it needs to show before it."""
TOGETHER = 6
"""So many of the first are fitted at once: with one of them missing the others are fitted wrong."""


def at_several_gains(ordinary: tuple[str, ...]) -> tuple[str, ...]:
    """The same with current limit and torque limit in each other's place.

    Load, friction and limits in degrees fall with the gain, and the speed at which the back-EMF
    takes up the voltage does not: recordings at several gains show how a limit falls with speed.
    Without that in the first joint model, all else in it is fitted wrong.

    >>> at_several_gains(("torque_saturation", "dead_time", "current_limit"))
    ('current_limit', 'dead_time', 'torque_saturation')
    """
    other = {"torque_saturation": "current_limit", "current_limit": "torque_saturation"}
    return tuple(other.get(name, name) for name in ordinary)
