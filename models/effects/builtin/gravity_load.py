"""Weight of an unbalanced surface."""

from __future__ import annotations

import math

from servosight.models.core import WEIGHT, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place, Usual


def term(theta: float, w: float, sine: float, cosine: float) -> float:
    """Torque [deg] of a mass off the axis at angle ``theta`` [deg]."""
    angle = theta * 0.017453292519943295
    return sine * math.sin(angle) + cosine * math.cos(angle)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Both signs of the sine, and of the cosine, at the size of the residual and above."""
    size = 3.0 * features.residual_deg
    return ((size, 0.0), (-size, 0.0), (0.0, size), (0.0, -size))


EFFECT = Effect(
    id="gravity_load",
    place=Place.LOAD,
    parameters=(
        Parameter(
            "sine", "deg", -720.0, 720.0, 0.0, "torque at 90 deg from the zero angle", WEIGHT
        ),
        Parameter("cosine", "deg", -720.0, 720.0, 0.0, "torque at the zero angle", WEIGHT),
    ),
    equation="load = sine sin(theta) + cosine cos(theta)",
    looks_like="the error at rest depends on the angle alone and bends with it; it is the same on "
    "the way up and on the way down",
    cause="surface or arm whose centre of mass lies off the hinge",
    confirm="turn the whole bench by 90 deg: the error moves with it; or balance the surface",
    remedy="balance weight, an integrator, or feedforward of the weight",
    source="Siciliano et al., Robotics (2009), section 7.3",
    starts=starts,
    term=term,
    usual=Usual.WEIGHT,
)
