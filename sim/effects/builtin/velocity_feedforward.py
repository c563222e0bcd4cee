"""A sender that gives a wanted speed beside each wanted angle, and a controller that weighs both.

The amplifier gets the angle and, weighted, the speed; what the derivative of the measured angle
brakes is the bench's own damping.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Polyline

_LONGEST_S = 0.032
"""A set-point that stays longer is no sample of a motion; then it is as many equal ones."""


def command(line: Polyline, values: EffectValues) -> Polyline:
    """``lead`` [s] times the wanted speed on top of the wanted angle.

    That speed is the slope of the command. Over a row of a held one it runs from what the last two
    differences between rows extrapolate to down to the last of them: in the mean it is the slope
    of the parabola through three rows, at the latest.
    """
    times, goals = [float(line[0][0])], [float(line[1][0])]
    at = goals[0]  # where the last set-point has come to
    before = 0.0
    for (start, first), (end, last) in itertools.pairwise(
        zip(*(x.tolist() for x in line), strict=True)
    ):
        slope = (last - first) / max(end - start, 1e-12)
        jump, now = first - at, start
        while now < end:
            resting = jump == before == 0.0
            parts = 1 if resting else math.ceil((end - now) / _LONGEST_S)
            until = now + (end - now) / parts
            speed = jump / (until - now)
            for t, rate in ((now, slope + 2.0 * speed - before), (until, slope + speed)):
                times.append(t)
                goals.append(first + slope * (t - start) + values["lead"] * rate)
            jump, before, now, at = 0.0, speed, until, last
    return np.array(times), np.array(goals)


EFFECT: HiddenEffect = HiddenEffect("velocity_feedforward", {"lead": 0.012}, command=command)
