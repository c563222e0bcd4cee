"""How far the camera looks from off the axis of rotation, as far as that is known."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Tilt:
    """The camera's tilt [deg] that the angles of a track are corrected for, None where none was
    found and it is taken to look along the axis.

    ``corrected_deg`` is the rms [deg] by which that changed the angles, ``sigma_deg`` one sigma of
    what remains in them [deg], each None where it is not known.
    """

    tilt_deg: float | None = None
    corrected_deg: float | None = None
    sigma_deg: float | None = None

    @property
    def doubt_deg(self) -> float:
        """What a tilt may do to angles that are not corrected for it [deg], rms; 0 where not known.

        >>> Tilt(tilt_deg=20.0, corrected_deg=0.4, sigma_deg=0.3).doubt_deg
        0.5
        """
        return math.hypot(self.corrected_deg or 0.0, self.sigma_deg or 0.0)


UNKNOWN = Tilt()
