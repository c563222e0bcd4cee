"""Dry friction of the motor's hinge: MuJoCo's friction loss, hard enough not to creep."""

from __future__ import annotations

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Add friction loss of ``level`` [deg]."""
    assembly.motor.frictionloss += assembly.bench.torque(values["level"])


EFFECT: HiddenEffect = HiddenEffect("coulomb_friction", {"level": 1.0}, edit=edit)
