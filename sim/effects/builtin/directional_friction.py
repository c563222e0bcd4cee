"""Friction in the reducer that grows with the torques at its two ends, each by a share of its own.

MuJoCo's friction loss is set anew before each step, from the amplifiers' torque in the middle of
the step, less the part of the damping that is back-EMF, and from what weight and springs bring to
the motor's hinge.
"""

from __future__ import annotations

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Friction of the shares [-] of the motor's torque and of the load; ``back_emf`` [s]."""

    def brake() -> None:
        motor = twin.drive_torque() - twin.back_emf_torque(values["back_emf"])
        twin.brake(abs(values["motor"] * motor + values["outer"] * twin.load_torque()))

    return brake


EFFECT: HiddenEffect = HiddenEffect(
    "directional_friction",
    {"motor": 0.3, "outer": 0.2, "back_emf": 0.0},
    regulate=regulate,
    steps_per_T=200,
)
