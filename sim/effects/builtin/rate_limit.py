"""Firmware that lets the wanted angle run no faster than a limit."""

from __future__ import annotations

import math

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Polyline


def command(line: Polyline, values: EffectValues) -> Polyline:
    """Follow a held command with slopes of at most ``rate`` [deg/s], exactly.

    Between jumps ``line`` is flat; each jump becomes a ramp, which the next jump may cut short.
    """
    rate = values["rate"]
    time_s, command_deg = line
    starts = time_s[::2]
    targets = command_deg[::2]
    at = float(targets[0])
    times, angles = [float(starts[0])], [at]
    for start, target, end in zip(starts, targets, [*starts[1:], math.inf], strict=True):
        reached = start + abs(target - at) / rate
        times.append(start)
        angles.append(at)
        if reached <= end:
            at = float(target)
        else:
            at += math.copysign(rate * (end - start), target - at)
            reached = end
        times.append(reached)
        angles.append(at)
    return np.array(times), np.array(angles)


EFFECT: HiddenEffect = HiddenEffect("rate_limit", {"rate": 150.0}, command=command)
