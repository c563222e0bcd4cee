"""Friction that first yields like a spring."""

from __future__ import annotations

import math

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(theta: float, start: float, last: float, level: float, stiffness: float) -> float:
    """Friction torque [deg] on the way from ``start``, where it was ``last``.

    Dahl's equation dF/dtheta = stiffness (1 - F sign(w) / level), solved for motion that does not
    turn round: passive at any step, and Coulomb's law as the stiffness grows.
    """
    way = theta - start
    bound = level if way > 0.0 else -level
    return bound - (bound - last) * math.exp(-stiffness * abs(way) / (level + 1e-12))


def resolution(
    T: float, w: float, acceleration: float, last: float, level: float, stiffness: float
) -> float:
    """Longest step [s] that follows the bristles bending; where they slide, any step does.

    Less than the bristles' own swing, and less than the way in which they bend.
    """
    reach = level / stiffness
    if abs(last) > 0.999 * level and T * w > reach:
        return math.inf
    swing = 0.4 * T / math.sqrt(1.0 + stiffness)
    bend = reach / (w + math.sqrt(w * w + acceleration * reach) + 1e-12)
    return max(min(swing, 0.5 * bend), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Friction of the residual's size, soft, middling and stiff at first."""
    size = features.residual_deg
    return (
        (1.0 * size, 5.0),
        (3.0 * size, 2.0),
        (1.5 * size, 25.0),
        (1.5 * size, 150.0),
    )


EFFECT = Effect(
    id="presliding",
    place=Place.BRISTLE,
    parameters=(
        Parameter("level", "deg", 0.0, 90.0, 0.0, "friction once it slides", TORQUE),
        Parameter(
            "stiffness", "deg/deg", 0.3, 1000.0, None, "torque for each degree before it", TORQUE
        ),
    ),
    equation="dF/dtheta = stiffness (1 - F sign(w) / level), friction = F (Dahl)",
    looks_like="small motion meets a spring and returns nearly to where it came from; loops of "
    "torque over angle after each reversal, wider with amplitude, before it slides at the level",
    cause="elastic contact in gears, bearings and seals before they roll or slide",
    confirm="push the surface by hand by a tenth of a degree and let go: it springs back; push it "
    "further and it stays",
    remedy="as for dry friction: lubricate, less preload, dither; a controller must not take this "
    "spring for one of the load",
    source="Dahl, A Solid Friction Model (1968); Canudas de Wit et al., IEEE TAC 40(3) (1995), "
    "eq. 1 to 3 without damping and Stribeck terms",
    starts=starts,
    term=term,
    resolution=resolution,
    contains=("coulomb_friction",),
)
