"""A limit of the torque that all amplifiers together bring to the motor.

Braking by back-EMF is not part of it: it is viscous damping of the hinge.
"""

from __future__ import annotations

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Limit the hinge's actuator force to ``limit`` [deg]."""
    limit = assembly.bench.torque(values["limit"])
    assembly.motor.actfrclimited = True
    assembly.motor.actfrcrange = [-limit, limit]


EFFECT: HiddenEffect = HiddenEffect("torque_saturation", {"limit": 5.0}, edit=edit)
