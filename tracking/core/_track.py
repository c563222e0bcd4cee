"""The result of tracking a video."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Result, frame
from servosight.tracking.core._channel import LUMA, Channel
from servosight.tracking.core._exposure import Shutters
from servosight.tracking.core._linkage import Linkage
from servosight.tracking.core._plane import PICTURE, MotionPlane
from servosight.tracking.core._rotation import turned
from servosight.tracking.core._tilt import UNKNOWN, Tilt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Box = tuple[int, int, int, int]
"""x, y, width, height [px]."""

_STALE = 3.0


class Flag(IntFlag):
    """Why a frame's angle deserves less trust; its sigma is widened accordingly."""

    NONE = 0
    COVERED = 1  # something hides part of the surface
    CUT = 2  # part of the surface is outside of the picture
    SATURATED = 4  # much of it is black or white
    DUPLICATE = 8  # the picture repeats the one before, so its time is not right
    LOST = 16  # not found: the angle is the last one's, the sigma that of all angles seen
    AFTER_GAP = 32  # frames before this one are missing from the file


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A part that turns: its pivot [px] and the share of what changes that it explains, 0 to 1."""

    pivot_px: tuple[float, float]
    explained: float


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Track(Result):
    """The moving part's angle in every frame of a video; all arrays have one entry a frame.

    Attributes:
        video: the video's file.
        method: the name of the method that measured it.
        time_s: mid-exposure of the middle row [s], (frames,).
        angle_deg: angle relative to the first frame [deg], counter-clockwise positive as seen,
            (frames,).
        sigma_deg: one standard deviation of each angle [deg], (frames,).
        flags: bits of ``Flag``, (frames,).
        pivot_px: x, y of the centre of rotation [px] (integer pixel centres, y down).
        template_px: x, y, width, height [px] of a box on the moving part, on the first frame.
        outline_px: x, y of the moving part's contour at angle zero [px], (points, 2).
        plane: the plane of motion in the picture.
        notes: remarks on view, times and camera, a sentence each.
        lost: those that say which pictures of the video are missing.
        shared_deg: change of the angles [deg] with one sigma of each error that all frames share
            (pivot, plane, exposure, readout), (frames, errors); None where not known.
            ``sigma_deg`` includes them, but they do not average out over frames.
        shutters: exposure and readout, given or found.
        candidates: the parts among which this one was chosen, the one that explains most first;
            empty where only one was looked for. ``TrackOptions.pick`` takes another.
        channel: what of the pictures was measured: their grey, or a sum of differences of colour.
        linkage: horn and pushrod, where they were looked for and found beside this surface.
        tilt: how far the camera looks from off the axis of rotation, and what that does to angles.

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from servosight import Track
    >>> track = Track(
    ...     video=Path("fin.mkv"), method="refine", time_s=np.arange(3) / 120,
    ...     angle_deg=np.array([0.0, 0.5, 1.5]), sigma_deg=np.full(3, 1e-3),
    ...     flags=np.zeros(3, np.uint8), pivot_px=(320.0, 240.0), template_px=(300, 220, 40, 40),
    ...     outline_px=np.array([[300.0, 220.0], [340.0, 220.0], [320.0, 120.0]]),
    ... )
    >>> track
    <Track: 3 frames in 0.01667 s, moved 1.5 deg, sigma 0.001 deg, pivot 320.00,240.00 px>
    """

    TYPE: ClassVar[str] = "track"

    video: Path
    method: str
    time_s: Array
    angle_deg: Array
    sigma_deg: Array
    flags: NDArray[np.uint8]
    pivot_px: tuple[float, float]
    template_px: Box
    outline_px: Array
    plane: MotionPlane = PICTURE
    notes: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    shared_deg: Array | None = None
    shutters: Shutters | None = None
    candidates: tuple[Candidate, ...] = ()
    channel: Channel = LUMA
    linkage: Linkage | None = None
    tilt: Tilt = UNKNOWN

    @property
    def frames(self) -> int:
        """How many frames the video has."""
        return len(self.time_s)

    @property
    def runner_up(self) -> Candidate | None:
        """The best of the other candidates, None where there is none."""
        away = [np.hypot(*np.subtract(c.pivot_px, self.pivot_px)) for c in self.candidates]
        own = int(np.argmin(away)) if away else 0
        return next((c for place, c in enumerate(self.candidates) if place != own), None)

    @property
    def found(self) -> NDArray[np.bool_]:
        """The frames in which the moving part was found; (frames,)."""
        return np.asarray((self.flags & Flag.LOST) == 0)

    @property
    def measured(self) -> NDArray[np.bool_]:
        """The frames whose angle was measured at their own time; (frames,).

        Not those in which the part was not found, nor a repeated picture of one that moved on.
        """
        usual = np.median(self.sigma_deg[self.found])
        stale = ((self.flags & Flag.DUPLICATE) > 0) & (self.sigma_deg > _STALE * usual)
        return np.asarray(self.found & ~stale)

    def save(self, path: Path | str) -> None:
        """Write the measured frames as ``time_s,angle_deg,sigma_deg`` to a ``.csv``, else JSON.

        A CSV is a recording's angle.csv; JSON holds everything, and ``servosight.load`` reads it
        back. Written completely or not at all. Frames that were not measured are left out of a CSV.
        """
        from servosight.models.io import write_angle

        if Path(path).suffix.lower() != ".csv":
            super().save(path)
            return
        rows = self.measured
        write_angle(Path(path), self.time_s[rows], self.angle_deg[rows], self.sigma_deg[rows])

    def to_frame(self) -> Any:
        """``time_s``, ``angle_deg``, ``sigma_deg`` and ``flags`` of each frame as a data frame."""
        names = ("time_s", "angle_deg", "sigma_deg", "flags")
        columns = [getattr(self, name).tolist() for name in names]
        return frame([dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the angle over time with two sigma on either side; a new figure without ``ax``."""
        import matplotlib.pyplot as plt

        axes = plt.subplots(layout="constrained")[1] if ax is None else ax
        rows = self.measured
        time_s, angle, sigma = self.time_s[rows], self.angle_deg[rows], self.sigma_deg[rows]
        axes.fill_between(time_s, angle - 2 * sigma, angle + 2 * sigma, alpha=0.3, linewidth=0)
        axes.plot(time_s, angle, linewidth=1.0)
        axes.set_xlabel("time [s]")
        axes.set_ylabel("angle [deg]")
        return axes

    def _summary(self) -> str:
        x, y = self.pivot_px
        return (
            f"{self.frames} frames in {self.time_s[-1] - self.time_s[0]:.4g} s, moved "
            f"{np.ptp(self.angle_deg):.4g} deg, sigma {np.median(self.sigma_deg):.2g} deg, pivot "
            f"{x:.2f},{y:.2f} px"
        )


def outline_at(track: Track, angle_deg: float) -> Array:
    """The moving part's contour [px] at an angle relative to the first frame; (points, 2)."""
    outline, pivot = (
        track.plane.of_picture(np.atleast_2d(place)) for place in (track.outline_px, track.pivot_px)
    )
    x, y = pivot[0]
    return track.plane.to_picture(turned(outline, (x, y), np.deg2rad(angle_deg)))
