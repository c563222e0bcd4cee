"""Pushrod between a servo horn and a surface horn."""

from __future__ import annotations

import math

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(angle: float, last: float, horn: float, offset: float) -> float:
    """Surface angle [deg]: both horns move a long pushrod by the same way.

    Where the way exceeds the surface's horn, the linkage stands in its dead centre.
    """
    radian = 0.017453292519943295
    way = horn * (math.sin(radian * (angle + offset)) - math.sin(radian * offset))
    return math.asin(min(max(way, -1.0), 1.0)) / radian


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Horns off to either side, and a servo horn shorter or longer than the surface's."""
    return ((1.0, 20.0), (1.0, -20.0), (0.7, 5.0), (1.4, -5.0))


EFFECT = Effect(
    id="linkage_geometry",
    place=Place.TRANSMISSION,
    parameters=(
        Parameter("horn", "-", 0.1, 5.0, 1.0, "radius of the servo horn over the surface horn"),
        Parameter("offset", "deg", -80.0, 80.0, 0.0, "servo horn off square at the zero angle"),
    ),
    equation="sin(y) = horn (sin(theta + offset) - sin(offset))",
    looks_like="the same command moves the surface further on one side than on the other, or "
    "less and less towards the ends; the error depends on the angle alone, at any speed",
    cause="horn not square to the pushrod, horns of different length",
    confirm="set the command to 0 and look: the horn must be square to the rod; read the surface "
    "at +20 and -20 deg",
    remedy="move the horn by a spline tooth, make the horns equal, or correct by a table",
    source="Norton, Design of Machinery (2012), section 4.5: four-bar linkage, here with a long "
    "rod",
    starts=starts,
    term=term,
)
