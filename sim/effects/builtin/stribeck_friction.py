"""Friction that falls from breakaway to sliding: a hard friction loss that the film relieves.

MuJoCo's friction loss holds the hinge at breakaway; a push with the motion takes away what the
film of grease carries. It vanishes at rest, so that sticking is left to the friction loss.
"""

from __future__ import annotations

import math

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Add friction loss of breakaway, ``level`` + ``excess`` [deg]."""
    assembly.motor.frictionloss += assembly.bench.torque(values["level"] + values["excess"])


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Relieve up to ``excess`` [deg], half-way at 0.83 ``speed`` [deg/s]."""
    excess, speed = twin.bench.torque(values["excess"]), math.radians(values["speed"])

    def relieve() -> None:
        twin.push(math.copysign(-excess * math.expm1(-((twin.speed / speed) ** 2)), twin.speed))

    return relieve


EFFECT: HiddenEffect = HiddenEffect(
    "stribeck_friction",
    {"level": 0.6, "excess": 0.8, "speed": 15.0},
    edit=edit,
    regulate=regulate,
)
