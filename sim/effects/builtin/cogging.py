"""Magnets that pull the rotor to its teeth: a push between teeth, held over each short step.

MuJoCo's motor has such a torque of its own, but as an actuator's: a limit of the drive would clip
it as well.
"""

from __future__ import annotations

import math

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Load by ``amplitude`` sin(2 pi theta/``period`` + ``phase``) [deg, deg, rad]."""
    largest, phase = twin.bench.torque(values["amplitude"]), values["phase"]
    per_rad = 360.0 / values["period"]
    return lambda: twin.push(-largest * math.sin(per_rad * twin.angle + phase))


EFFECT: HiddenEffect = HiddenEffect(
    "cogging", {"amplitude": 0.8, "period": 15.0, "phase": 0.5}, regulate=regulate
)
