"""A supply voltage that the back-EMF uses up: the faster, the less is left to drive.

Before each step the drive's limits are set from the motor's speed, as an amplifier at its rails has
them: less to drive, more to brake.
"""

from __future__ import annotations

import math

import mujoco

from servosight.sim.bench import STRONG_NM, Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Make the drive one with limits, if it is not."""
    if assembly.motor.actfrclimited != mujoco.mjtLimited.mjLIMITED_TRUE:
        assembly.motor.actfrclimited = True
        assembly.motor.actfrcrange = [-STRONG_NM, STRONG_NM]


def supply(twin: Twin, values: EffectValues) -> Regulator:
    """``stall`` [deg] at rest, nothing at ``no_load_speed`` [deg/s], a line between and beyond."""
    stall = twin.bench.torque(values["stall"])
    fastest = math.radians(values["no_load_speed"])
    limits = twin.drive_range
    low, high = limits.tolist()

    def limit() -> None:
        share = twin.speed / fastest
        limits[0] = min(max(-stall * (1.0 + share), low), 0.0)
        limits[1] = max(min(stall * (1.0 - share), high), 0.0)

    return limit


EFFECT: HiddenEffect = HiddenEffect(
    "speed_limit", {"stall": 12.0, "no_load_speed": 250.0}, edit=edit, supply=supply
)
