"""The effects of an ordinary servo, which the wider search tries together."""

from __future__ import annotations

ORDINARY = (
    "gravity_load",
    "load_dependent_friction",
    "torque_saturation",
    "supply_sag",
    "stribeck_friction",
    "coulomb_friction",
    "dead_time",
    "backlash",
    "rate_limit",
    "speed_limit",
    "current_limit",
)
"""What an ordinary geared servo has; in this order each has what it needs to show before it."""
