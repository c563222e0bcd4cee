"""The surface on a spring of its own, behind the horn."""

from __future__ import annotations

import math

from servosight.models.core import InputError
from servosight.sim.bench import Assembly, linear
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Hinge the surface to the horn by a spring.

    With the motor locked it rings at ``frequency`` [Hz] with ratio ``damping`` [-]; it carries
    ``inertia_ratio`` of the bench's inertia, the motor's side keeps the rest.
    Raises InputError for a spring too stiff for the time step.
    """
    bench = assembly.bench
    highest = (1.0 - values["inertia_ratio"]) / (1.0 + 2.0 * values["damping"])
    highest /= 2.0 * math.pi * float(assembly.spec.option.timestep)
    if values["inertia_ratio"] == 0.0:  # nothing on the spring: the surface stays welded
        return
    if not 0.0 < values["frequency"] <= highest:
        raise InputError(
            f"flexible_shaft.frequency is {values['frequency']:g} Hz, expected more than 0 and at "
            f"most {highest:.0f} Hz, which the simulation's time step resolves; lower it or leave "
            f"the effect out"
        )
    if assembly.sensor != "motor":
        raise InputError(
            "flexible_shaft and feedback_backlash cannot be simulated in one servo, expected one "
            "of them: the spring would push on a shaft that is free in its gap; leave one out"
        )
    omega = 2.0 * math.pi * values["frequency"]
    inertia = values["inertia_ratio"] * bench.inertia_kg_m2
    surface = assembly.spec.body("surface")
    assembly.motor.armature += bench.surface_inertia_kg_m2 - inertia
    surface.inertia = [inertia] * 3
    shaft = assembly.hinge(surface, "shaft")
    shaft.stiffness = linear(inertia * omega**2)
    shaft.damping = linear(2.0 * values["damping"] * inertia * omega)
    assembly.surface.append("shaft")


EFFECT: HiddenEffect = HiddenEffect(
    "flexible_shaft", {"frequency": 12.0, "damping": 0.08, "inertia_ratio": 0.3}, edit=edit
)
