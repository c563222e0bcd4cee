"""Bristles that bend before they slip, advanced along the path and not in time.

Dahl's friction depends on the path alone, dF/dx = s (1 - F/level sign(dx)), which an exponential
solves for a motion one way: so it is exact at any speed, where an integrator of its rate w s/level
would need steps of microseconds (Dahl, A solid friction model, 1968).
"""

from __future__ import annotations

import math

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Bristles of ``stiffness`` [deg/deg] that slip at ``level`` [deg]."""
    level = values["level"]
    if level == 0.0:
        return lambda: None
    per_rad = math.degrees(values["stiffness"] / level)
    unit = twin.bench.torque(1.0)
    position, motor = twin.data.qpos, twin.motor
    bent = 0.0  # friction torque at angle ``at`` [deg]
    at = float(position[motor])

    def moved(way: float) -> float:
        slip = math.copysign(level, way)
        return slip + (bent - slip) * math.exp(-per_rad * abs(way))

    def bend() -> None:
        nonlocal bent, at
        now = float(position[motor])
        bent, at = moved(now - at), now
        twin.push(-unit * moved(twin.angle - at))

    return bend


EFFECT: HiddenEffect = HiddenEffect(
    "presliding", {"level": 1.2, "stiffness": 4.0}, regulate=regulate
)
