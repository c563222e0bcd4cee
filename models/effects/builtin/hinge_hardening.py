"""Load that stiffens with angle."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import one


def term(theta: float, w: float, cubic: float) -> float:
    """Torque [deg] at ``theta`` [deg], towards the zero angle."""
    return cubic * theta * theta * theta


def resolution(T: float, theta: float, cubic: float) -> float:
    """Longest step [s] that follows the swing on the stiffer spring."""
    return max(0.4 * T / math.sqrt(1.0 + 3.0 * cubic * theta * theta), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """As the residual says, and torques of a tenth and a half of the amplitude at its end."""
    size = 1.0 / features.amplitude_deg**2
    read = one(features.curves, features.curves.angle_deg**3)
    return ((max(read, 0.02 * size),), (0.1 * size,), (0.5 * size,))


EFFECT = Effect(
    id="hinge_hardening",
    place=Place.LOAD,
    parameters=(
        Parameter("cubic", "deg/deg^3", 0.0, 1.0, 0.0, "torque over the cube of the angle", TORQUE),
    ),
    equation="load = cubic theta^3",
    looks_like="large angles fall short and ring faster than small ones, alike on both sides; the "
    "error at rest grows with the cube of the angle",
    cause="aerodynamic hinge moment, an elastic stop, a boot or hose that is bent",
    confirm="hang weights on the surface at 10, 20 and 30 deg: the torque grows much faster than "
    "the angle; without the surface the error is gone",
    remedy="free the hose, move the hinge towards the centre of pressure, or feedforward of the "
    "load",
    source="Etkin and Reid, Dynamics of Flight (1996), section 2.5: hinge moments; cubic as in "
    "Duffing's equation (1918)",
    starts=starts,
    term=term,
    resolution=resolution,
)
