"""A pulse width that counts whole ticks: the command in steps."""

from __future__ import annotations

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Polyline


def command(line: Polyline, values: EffectValues) -> Polyline:
    """The held command at the nearest multiple of ``step`` [deg]."""
    time_s, command_deg = line
    if values["step"] == 0.0:
        return line
    return time_s, values["step"] * np.floor(command_deg / values["step"] + 0.5)


EFFECT: HiddenEffect = HiddenEffect("command_quantization", {"step": 1.0}, command=command)
