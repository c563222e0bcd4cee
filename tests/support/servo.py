"""Actuators for tests, and a command for them."""

from __future__ import annotations

from collections.abc import Mapping

from servosight.models.core import Actuator, Estimate, Recording
from servosight.models.excitation import standard

LINEAR = {"k": 0.9, "T": 0.04, "xi": 0.6, "bias": 0.5}


def actuator(core: Mapping[str, float] = LINEAR, **effects: float) -> Actuator:
    """An actuator with known values and no sigma; effects as ``backlash__gap=0.5``."""
    values = {**core, **{name.replace("__", "."): value for name, value in effects.items()}}
    names = tuple(dict.fromkeys(name.split("__")[0] for name in effects))
    return Actuator({n: Estimate(v, None, "") for n, v in values.items()}, names)


def short_trial(seconds: float = 6.0) -> Recording:
    """The standard command over a shorter time, from rest; its angle is nobody's."""
    rows = standard(seconds, 20.0, rate_hz=250.0)
    return Recording("short", rows.time_s, rows.command_deg, rows.time_s, 0.0 * rows.time_s)
