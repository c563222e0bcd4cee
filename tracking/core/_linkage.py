"""What joins two parts of a video that turn: which one is the horn, and the rod between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from servosight.models.core import Array

_PIVOT_PX = 0.12
"""By so much, on the twin's videos, the pivot of a horn is off along either axis (rms).

What is near the horn's pin moves nearly with the horn, as the rod's end, and is learnt with it.
"""

ToldBy = Literal["given", "play", "size"]
"""Who is the horn: as the user says, the part that moves on while the other rests, the smaller."""


@dataclass(frozen=True, kw_only=True)
class Rod:
    """A rod from pin to pin on the first frame, x and y [px].

    ``explained`` is the share of the change between the two parts that it accounts for, where it
    passes; ``slack_px`` by how much the pins come apart (rms), as play in them makes it.
    """

    horn_px: tuple[float, float]
    surface_px: tuple[float, float]
    explained: float
    slack_px: float

    @property
    def length_px(self) -> float:
        """From pin to pin."""
        return float(np.hypot(*np.subtract(self.surface_px, self.horn_px)))


@dataclass(frozen=True, kw_only=True)
class Linkage:
    """Surface, horn and pushrod, as far as they were found.

    ``surface_px`` and ``horn_px`` are the pivots [px]; ``told_by`` how the horn was told from the
    surface; ``rod`` what joins them, None where the pictures show none.
    """

    surface_px: tuple[float, float]
    horn_px: tuple[float, float]
    told_by: ToldBy
    rod: Rod | None = None

    def doubt_deg(self, angle_deg: Array) -> Array:
        """Errors of the horn's angles [deg] by one sigma of its pivot, (samples, errors).

        Those that the rod's end makes, which the horn's own sigma does not hold; none without one.
        """
        if self.rod is None:
            return np.zeros((angle_deg.size, 0))
        radius_px = float(np.hypot(*np.subtract(self.rod.horn_px, self.horn_px)))
        angle = np.deg2rad(angle_deg)
        shift = np.rad2deg(_PIVOT_PX / radius_px)
        return np.column_stack([shift * np.sin(angle), shift * (1.0 - np.cos(angle))])

    @property
    def sentences(self) -> tuple[str, ...]:
        """Who is who, and where the rod is."""
        (x, y), (hx, hy) = self.surface_px, self.horn_px
        how = {
            "given": "as given",
            "play": "the horn moves on while the surface rests in the play between them",
            "size": "the horn is the smaller part; no play shows which one drives the other",
        }[self.told_by]
        found = f"surface about {x:.1f},{y:.1f} px, horn about {hx:.1f},{hy:.1f} px: {how}"
        if self.rod is None:
            return (found, "no pushrod is seen between the two")
        (rx, ry), (tx, ty) = self.rod.horn_px, self.rod.surface_px
        return (
            found,
            f"pushrod of {self.rod.length_px:.0f} px from {rx:.0f},{ry:.0f} px on the horn to "
            f"{tx:.0f},{ty:.0f} px on the surface: it explains {self.rod.explained:.0%} of what "
            "changes there",
        )
