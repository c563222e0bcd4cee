"""A controller whose integral has a limit."""

from __future__ import annotations

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin
from servosight.sim.effects.builtin import integral_action


def supply(twin: Twin, values: EffectValues) -> Regulator:
    """As integral action, up to ``limit`` [deg]."""
    return integral_action.integral(twin, values, values["limit"])


EFFECT: HiddenEffect = HiddenEffect(
    "limited_integral", {"rate": 8.0, "lag": 0.01, "limit": 3.0}, supply=supply
)
