"""A horn whose mass lies off the hinge, under gravity.

It hangs on the motor's side of any play or spring. The hinge's inertia stays what the bench says:
the mass's own share, m r^2, is taken out of the rotor's.
"""

from __future__ import annotations

import math

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect

_SHARE = 0.05  # of the rotor's inertia that the mass takes over


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Hang a mass so that gravity loads by ``sine`` sin(theta) + ``cosine`` cos(theta) [deg].

    At angle a from the horn, m g r cos(theta + a) = m g r (cos(a) cos(theta) - sin(a) sin(theta)).
    """
    moment = assembly.bench.torque(math.hypot(values["sine"], values["cosine"]))
    if moment == 0.0:
        return
    direction = math.atan2(-values["sine"], values["cosine"])
    gravity = -float(assembly.spec.option.gravity[1])
    taken = _SHARE * assembly.bench.armature_kg_m2
    radius = taken * gravity / moment
    horn = assembly.spec.body("horn")
    horn.mass = moment / (gravity * radius)
    horn.ipos = [radius * math.cos(direction), radius * math.sin(direction), 0.0]
    assembly.motor.armature -= taken


EFFECT: HiddenEffect = HiddenEffect("gravity_load", {"sine": 4.0, "cosine": 20.0}, edit=edit)
