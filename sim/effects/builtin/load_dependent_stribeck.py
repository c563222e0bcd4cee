"""Friction in the reducer that grows with the torque it transmits, and vanishes with speed.

MuJoCo's friction loss is set anew before each step, from the amplifiers' torque in the middle of
the step, less the part of the damping that is back-EMF, and from what weight and springs bring to
the motor's hinge.
"""

from __future__ import annotations

import math

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Friction of ``excess`` [-] times the torque at rest, e^-1 of it at ``speed`` [deg/s].

    ``back_emf`` is in seconds.
    """
    speed = math.radians(values["speed"])

    def brake() -> None:
        share = values["excess"] * math.exp(-((twin.speed / speed) ** 2))
        motor = twin.drive_torque() - twin.back_emf_torque(values["back_emf"])
        twin.brake(share * abs(motor + twin.load_torque()))

    return brake


EFFECT: HiddenEffect = HiddenEffect(
    "load_dependent_stribeck",
    {"excess": 0.3, "speed": 60.0, "back_emf": 0.0},
    regulate=regulate,
    steps_per_T=200,
)
