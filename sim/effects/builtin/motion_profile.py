"""Firmware that plans a trapezoid of speed to each new goal, from where it is and how it moves."""

from __future__ import annotations

import math

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Polyline

_KNOT_S = 5e-4


def command(line: Polyline, values: EffectValues) -> Polyline:
    """Plan to each goal of a held command with ``rate`` [deg/s] and ``acceleration`` [deg/s^2].

    A plan is followed until the next goal arrives, and drawn with knots every 0.5 ms.
    """
    time_s, command_deg = line
    starts, goals = time_s[::2], command_deg[::2]
    at, speed = float(goals[0]), 0.0
    times, angles = [float(starts[0])], [at]
    for start, goal, end in zip(starts, goals, [*starts[1:], math.inf], strict=True):
        clock = float(start)
        for change, duration in _plan(goal - at, speed, values["rate"], values["acceleration"]):
            lasts = min(duration, end - clock)
            if lasts <= 0.0:
                continue
            count = 1 if change == 0.0 else math.ceil(lasts / _KNOT_S)
            for tau in (np.arange(1, count + 1) / count * lasts).tolist():
                times.append(clock + tau)
                angles.append(at + tau * (speed + 0.5 * tau * change))
            at += lasts * (speed + 0.5 * lasts * change)
            speed += lasts * change
            clock += lasts
        if clock < end:
            at, speed = float(goal), 0.0
            times.append(clock if math.isinf(end) else float(end))
            angles.append(at)
    return np.array(times), np.array(angles)


def _plan(way: float, speed: float, rate: float, most: float) -> list[tuple[float, float]]:
    """Accelerations [deg/s^2] and durations [s] that end at rest after ``way`` [deg].

    Where the speed is too high to stop in time, it stops first, beyond the goal, and comes back.
    """
    stopping = 0.5 * speed * abs(speed) / most
    side = math.copysign(1.0, way - stopping)
    towards = side * speed
    distance = side * way
    peak = math.sqrt(max(most * distance + 0.5 * towards**2, 0.0))
    top = min(peak, rate)
    cruise = distance - (top**2 - 0.5 * towards**2) / most
    return [
        (side * most, (top - towards) / most),
        (0.0, max(cruise, 0.0) / top if top > 0.0 else 0.0),
        (-side * most, top / most),
    ]


EFFECT: HiddenEffect = HiddenEffect(
    "motion_profile", {"rate": 200.0, "acceleration": 8000.0}, command=command
)
