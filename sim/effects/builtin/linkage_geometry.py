"""A pushrod between two horns: the four-bar linkage closed exactly, pin by pin.

The rod lies along x and the surface's horn, of radius 1, stands square to it at the zero angle; the
rod is long against both horns, so that its own turning does not count.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.sim.effects._contract import EffectValues, HiddenEffect
from servosight.sim.linkage import CRANK_MM, Linkage

_ROD = 1e4  # surface horns


def output(angle_deg: Array, values: EffectValues) -> Array:
    """Surface angle [deg] where both pins are a rod apart; at the dead centre it stands.

    ``horn`` [-] is the servo horn's radius, ``offset`` [deg] its angle off square at zero.
    Circle intersection as in Norton, Design of Machinery (2012), section 4.5.
    """
    turned = np.radians(angle_deg + values["offset"])
    square = np.radians(values["offset"])
    # From the servo's pin to the surface's hinge, which stands so that the rod lies along x.
    along = _ROD + values["horn"] * (np.sin(turned) - np.sin(square))
    across = values["horn"] * (np.cos(square) - np.cos(turned)) - 1.0
    apart = np.hypot(along, across)
    reach = (apart - _ROD) * (apart + _ROD) + 1.0
    return np.asarray(
        np.degrees(np.arctan2(across, along) + np.arcsin(np.clip(reach / (2.0 * apart), -1.0, 1.0)))
    )


def drawn(values: EffectValues) -> Linkage:
    """The horn by its ratio to the bench's lever."""
    return Linkage(values["horn"] * CRANK_MM, CRANK_MM, values["offset"])


EFFECT: HiddenEffect = HiddenEffect(
    "linkage_geometry", {"horn": 1.0, "offset": 20.0}, output=output, linkage=drawn
)
