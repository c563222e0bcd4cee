"""Friction in the reducer that grows with the torque it transmits.

MuJoCo's friction loss is a constant, so it is set anew before each step, from the amplifiers'
torque in the middle of the step.
"""

from __future__ import annotations

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Friction of ``ratio`` [-] times the drive."""

    def brake() -> None:
        twin.brake(values["ratio"] * abs(twin.drive_torque()))

    return brake


EFFECT: HiddenEffect = HiddenEffect(
    "load_dependent_friction", {"ratio": 0.5}, regulate=regulate, steps_per_T=200
)
