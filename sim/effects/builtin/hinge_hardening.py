"""A hinge that stiffens with the angle: the cubic term of MuJoCo's joint spring."""

from __future__ import annotations

import math

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Load by ``cubic`` theta^3 [deg] with theta in degrees."""
    linear, square, cubic = assembly.motor.stiffness
    cubic += assembly.bench.torque(values["cubic"]) * math.degrees(1.0) ** 3
    assembly.motor.stiffness = [linear, square, cubic]


EFFECT: HiddenEffect = HiddenEffect("hinge_hardening", {"cubic": 5e-4}, edit=edit)
