"""The surface on a spring of its own, behind the horn."""

from __future__ import annotations

import math

from servosight.sim.bench import Assembly, linear
from servosight.sim.effect import HiddenEffect, Values


def edit(assembly: Assembly, values: Values) -> None:
    """Hinge the surface to the horn by a spring.

    With the motor locked it rings at ``frequency`` [Hz] with ratio ``damping`` [-]; it carries
    ``inertia_ratio`` of the bench's inertia, the motor's side keeps the rest.
    """
    bench = assembly.bench
    omega = 2.0 * math.pi * values["frequency"]
    inertia = values["inertia_ratio"] * bench.inertia_kg_m2
    surface = assembly.spec.body("surface")
    assembly.motor.armature += bench.surface_inertia_kg_m2 - inertia
    surface.inertia = [inertia] * 3
    shaft = assembly.hinge(surface, "shaft")
    shaft.stiffness = linear(inertia * omega**2)
    shaft.damping = linear(2.0 * values["damping"] * inertia * omega)
    assembly.surface.append("shaft")


EFFECT = HiddenEffect(
    "flexible_shaft", {"frequency": 12.0, "damping": 0.08, "inertia_ratio": 0.3}, edit=edit
)
