"""What tracking a video gives."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.tracking.core._exposure import Shutters
from servosight.tracking.core._plane import PICTURE, Plane
from servosight.tracking.core._rotation import turned

Method = Literal["match", "refine", "marker"]
Box = tuple[int, int, int, int]

_STALE = 3.0


class Flag(IntFlag):
    """Why a frame's angle deserves less trust; its sigma is widened accordingly."""

    NONE = 0
    COVERED = 1  # something hides part of the surface
    CUT = 2  # part of the surface is outside of the picture
    SATURATED = 4  # much of it is black or white
    DUPLICATE = 8  # the picture is the one before, so the time is not its own
    LOST = 16  # not found: the angle is the last one's, the sigma that of all angles seen
    AFTER_GAP = 32  # frames before this one are missing from the file


@dataclass(frozen=True)
class Track:
    """The surface's angle in every frame; all arrays (frames,).

    ``time_s`` is mid-exposure of the middle row; ``angle_deg`` is relative to the first frame,
    counter-clockwise positive as seen; ``flags`` are ``Flag`` bits. ``pivot_px`` is x, y (integer
    centres, y down), ``template_px`` the box (x, y, width, height) on the first frame,
    ``outline_px`` (points, 2) the moving part's contour at angle zero. ``plane`` is that in which
    it turns, ``notes`` what to know about the view and the times, a sentence each.
    ``shared_deg`` (frames, errors), where known, is what one sigma of each error that all frames
    share makes of the angles, by pivot and plane: ``sigma_deg`` holds their size, but they do not
    average out over frames. ``shutters`` are those that were told or found.
    """

    video: Path
    method: Method
    time_s: Array
    angle_deg: Array
    sigma_deg: Array
    flags: NDArray[np.uint8]
    pivot_px: tuple[float, float]
    template_px: Box
    outline_px: Array
    plane: Plane = PICTURE
    notes: tuple[str, ...] = ()
    shared_deg: Array | None = None
    shutters: Shutters | None = None

    @property
    def frames(self) -> int:
        """How many frames the video has."""
        return len(self.time_s)

    @property
    def found(self) -> NDArray[np.bool_]:
        """The frames in which the surface was found; shape (frames,)."""
        return np.asarray((self.flags & Flag.LOST) == 0)

    @property
    def measured(self) -> NDArray[np.bool_]:
        """The frames that tell an angle of their own time; shape (frames,).

        Not those in which the surface was not found, nor a repeated picture of one that moved on.
        """
        usual = np.median(self.sigma_deg[self.found])
        stale = ((self.flags & Flag.DUPLICATE) > 0) & (self.sigma_deg > _STALE * usual)
        return np.asarray(self.found & ~stale)


def outline_at(track: Track, angle_deg: float) -> Array:
    """The moving part's contour at an angle relative to the first frame; (points, 2) as x, y."""
    outline, pivot = (
        track.plane.of_picture(np.atleast_2d(place)) for place in (track.outline_px, track.pivot_px)
    )
    x, y = pivot[0]
    return track.plane.to_picture(turned(outline, (x, y), np.deg2rad(angle_deg)))
