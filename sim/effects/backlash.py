"""Play between the horn and a light fin that its own friction holds.

Motor and fin both hinge to the world; a fixed tendon of limited range couples them, so the angle
between them is free within the gap. The fin's inertia and friction are what remains of a light
surface: small enough that the motor hardly feels them, friction large enough against inertia that
the fin stays where it was left, as the play operator wants. All other inertia is the motor's.
"""

from __future__ import annotations

import mujoco

from servosight.sim.bench import HARD_IMPEDANCE, HARD_REFERENCE, Assembly, link
from servosight.sim.effect import HiddenEffect, Values

FIN_SHARE = 1e-5  # of the bench's inertia
FIN_FRICTION_DEG = 0.001  # decelerates the fin as a position error of 100 deg would the motor


def edit(assembly: Assembly, values: Values) -> None:
    """Put the fin behind a play of full width ``gap`` [deg]."""
    if values["gap"] == 0.0:  # MuJoCo refuses an empty range
        return
    spec, bench = assembly.spec, assembly.bench
    inertia = FIN_SHARE * bench.inertia_kg_m2
    assembly.motor.armature -= inertia
    fin = assembly.hinge(link(spec.worldbody, "fin", inertia), "fin")
    fin.frictionloss = bench.torque(FIN_FRICTION_DEG)

    half = 0.5 * values["gap"] * mujoco.mjPI / 180.0
    tendon = spec.add_tendon(
        name="play",
        limited=True,
        range=[-half, half],
        solref_limit=HARD_REFERENCE,
        solimp_limit=HARD_IMPEDANCE,
    )
    for hinge in assembly.surface:
        tendon.wrap_joint(hinge, 1.0)
    tendon.wrap_joint("fin", -1.0)
    assembly.surface[:] = ["fin"]


EFFECT = HiddenEffect("backlash", {"gap": 2.0}, edit=edit)
