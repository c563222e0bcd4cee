"""The effects of an ordinary servo, which the wider search tries together."""

from __future__ import annotations

ORDINARY = (
    "gravity_load",
    "load_dependent_friction",
    "current_limit",
    "stribeck_friction",
    "dead_time",
    "rate_limit",
    "supply_sag",
    "coulomb_friction",
    "backlash",
    "speed_limit",
    "torque_saturation",
    "feedback_backlash",
    "dead_band",
)
"""What an ordinary geared servo has; in this order each has what it needs to show before it.

Of two effects of which one contains the other the wider comes first: what it has too much is left
out later, what the other lacks leads all else into a wrong minimum.
"""
TOGETHER = 6
"""So many of the first are fitted at once: with one of them missing the others are fitted wrong."""
