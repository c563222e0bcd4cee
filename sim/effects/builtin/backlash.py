"""Play between the horn and a light fin that its own friction holds.

Motor and fin both hinge to the world; a fixed tendon of limited range couples them, so the angle
between them is free within the gap. The fin's inertia and friction are what remains of a light
surface: small enough that the motor hardly feels them, friction large enough against inertia that
the fin stays where it was left, as the play operator wants. All other inertia is the motor's.
"""

from __future__ import annotations

import math

from servosight.sim.bench import HARD_IMPEDANCE, Assembly, link
from servosight.sim.effects._contract import EffectValues, HiddenEffect

FIN_SHARE = 1e-6  # of the bench's inertia
FIN_FRICTION_DEG = 0.0001  # decelerates the fin as a position error of 100 deg would the motor


def behind_play(
    assembly: Assembly,
    name: str,
    hinges: list[str],
    gap_deg: float,
    share: float = FIN_SHARE,
    friction_deg: float = FIN_FRICTION_DEG,
) -> None:
    """Hinge a body behind ``hinges``, free to turn by ``gap_deg`` against them.

    It takes ``share`` of the bench's inertia over from the motor.
    """
    inertia = share * assembly.bench.inertia_kg_m2
    assembly.motor.armature -= inertia
    hinge = assembly.hinge(link(assembly.spec.worldbody, name, inertia), name)
    hinge.frictionloss = assembly.bench.torque(friction_deg)
    half = 0.5 * math.radians(gap_deg)
    tendon = assembly.spec.add_tendon(
        limited=True,
        range=[-half, half],
        solref_limit=assembly.hard_reference,
        solimp_limit=HARD_IMPEDANCE,
    )
    for one in hinges:
        tendon.wrap_joint(one, 1.0)
    tendon.wrap_joint(name, -1.0)


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Put the fin behind a play of full width ``gap`` [deg]."""
    if values["gap"] == 0.0:  # MuJoCo refuses an empty range
        return
    behind_play(assembly, "fin", assembly.surface, values["gap"])
    assembly.surface[:] = ["fin"]


EFFECT: HiddenEffect = HiddenEffect("backlash", {"gap": 2.0}, edit=edit)
