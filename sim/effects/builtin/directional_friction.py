"""Friction in the reducer that grows with the torques at its two ends, each by a share of its own.

MuJoCo's friction loss is set anew before each step, from the amplifiers' torque in the middle of
the step and from what weight and springs bring to the motor's hinge.
"""

from __future__ import annotations

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Friction loss of the motor's hinge: what it has, plus the shares [-] of drive and load."""
    data, motor, loss = twin.data, twin.motor, twin.model.dof_frictionloss
    level = float(loss[motor])

    def set_friction() -> None:
        # One hinge alone has no Coriolis force: gravity is all that the bias holds.
        load = float(data.qfrc_bias[motor] - data.qfrc_spring[motor])
        loss[motor] = level + abs(values["motor"] * twin.drive_torque() + values["outer"] * load)

    return set_friction


EFFECT: HiddenEffect = HiddenEffect(
    "directional_friction", {"motor": 0.3, "outer": 0.2}, regulate=regulate, steps_per_T=200
)
