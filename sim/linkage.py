"""Horn, pushrod and lever of the bench as a four-bar linkage: where its pins are.

The servo's shaft lies below the surface's hinge. The lever points left from the hinge at the zero
angle, the horn points left from the shaft, turned by ``offset_deg``; the rod joins their pins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array

SHAFT_MM = (0.0, -38.0)
"""The servo's shaft from the hinge; x to the right, y up."""

CRANK_MM = 20.0
"""Radius of the lever, and of the horn where nothing else is said."""


@dataclass(frozen=True)
class Linkage:
    """Radius of horn and lever [mm], and the horn's angle off square at zero [deg]."""

    horn_mm: float = CRANK_MM
    lever_mm: float = CRANK_MM
    offset_deg: float = 0.0

    @property
    def rod_mm(self) -> float:
        """Length of the rod, from pin to pin."""
        lower, upper = self.pins_mm(0.0, 0.0)
        return float(np.hypot(*(upper - lower)))

    def pins_mm(self, horn_deg: float, surface_deg: float) -> tuple[Array, Array]:
        """The pins of horn and lever, (2,) each, from the hinge."""
        horn, lever = math.radians(horn_deg + self.offset_deg), math.radians(surface_deg)
        lower = np.array(SHAFT_MM) - self.horn_mm * np.array([math.cos(horn), math.sin(horn)])
        return lower, -self.lever_mm * np.array([math.cos(lever), math.sin(lever)])

    def rod_deg(self, horn_deg: float, surface_deg: float) -> float:
        """The rod's angle from the vertical, counter-clockwise positive."""
        lower, upper = self.pins_mm(horn_deg, surface_deg)
        x, y = upper - lower
        return math.degrees(math.atan2(-x, y))

    def surface_deg(self, horn_deg: Array) -> Array:
        """Where the rod puts the surface, (n,); at the dead centre it stands.

        Norton, Design of Machinery (2012), section 4.5, in the branch of the zero angle.

        >>> Linkage().surface_deg(np.array([-10.0, 0.0, 20.0])).round(9).tolist()
        [-10.0, 0.0, 20.0]
        """
        turned = np.radians(horn_deg + self.offset_deg)
        x = -SHAFT_MM[0] + self.horn_mm * np.cos(turned)
        y = -SHAFT_MM[1] + self.horn_mm * np.sin(turned)
        apart = np.hypot(x, y)
        along = (apart**2 + self.lever_mm**2 - self.rod_mm**2) / (2.0 * self.lever_mm * apart)
        inner = np.arccos(np.clip(along, -1.0, 1.0))
        return np.asarray(np.degrees(np.arctan2(y, x) - inner))
