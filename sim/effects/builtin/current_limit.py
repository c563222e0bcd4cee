"""A limiter of the motor's current: the drive's limits move with the back-EMF.

Before each step the drive's limits are set about the torque that balances the back-EMF at the
motor's speed, within limits that are there already.
"""

from __future__ import annotations

import mujoco

from servosight.sim.bench import STRONG_NM, Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Make the drive one with limits, if it is not."""
    if assembly.motor.actfrclimited != mujoco.mjtLimited.mjLIMITED_TRUE:
        assembly.motor.actfrclimited = True
        assembly.motor.actfrcrange = [-STRONG_NM, STRONG_NM]


def supply(twin: Twin, values: EffectValues) -> Regulator:
    """``limit`` [deg] to both sides of ``back_emf`` [s] times the speed."""
    width = twin.bench.torque(values["limit"])
    limits = twin.drive_range

    def limit() -> None:
        low, high = limits.tolist()
        centre = twin.back_emf_torque(values["back_emf"])
        limits[0] = min(max(centre - width, low), high)
        limits[1] = min(max(centre + width, low), high)

    return limit


EFFECT: HiddenEffect = HiddenEffect(
    "current_limit", {"limit": 3.0, "back_emf": 0.006}, edit=edit, supply=supply
)
