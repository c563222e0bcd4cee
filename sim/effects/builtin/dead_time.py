"""A bus that hands the command on late, to the fraction of a step."""

from __future__ import annotations

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Polyline


def command(line: Polyline, values: EffectValues) -> Polyline:
    """The same knots, ``delay`` [s] later."""
    time_s, command_deg = line
    return time_s + values["delay"], command_deg


EFFECT: HiddenEffect = HiddenEffect("dead_time", {"delay": 0.012}, command=command)
