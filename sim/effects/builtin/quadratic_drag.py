"""A surface that stirs the fluid: the quadratic term of the hinge's own damping."""

from __future__ import annotations

import math

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Damp by ``coefficient`` w |w| [deg] with w in deg/s."""
    linear, square, cubic = assembly.motor.damping
    square += assembly.bench.torque(values["coefficient"]) * math.degrees(1.0) ** 2
    assembly.motor.damping = [linear, square, cubic]


EFFECT: HiddenEffect = HiddenEffect("quadratic_drag", {"coefficient": 2e-4}, edit=edit)
