"""The options of tracking: what is given of a video, and the method."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from servosight.tracking.core._plane import CameraGeometry
from servosight.tracking.core._track import Box, Track

MarkerFamily = Literal["aruco", "apriltag"]
"""Kinds of square markers that OpenCV finds."""


@dataclass(frozen=True, kw_only=True)
class TrackOptions:
    """What is given of a video, and the method; each value has a default.

    Attributes:
        method: a name in ``servosight.tracking.methods.METHODS``: "refine", "match" or "marker".
        pivot: x, y [px] about where the centre of rotation is (integer pixel centres, y down):
            ``refine`` finds it from there.
        template: x, y, width, height [px] of a box around the moving part.
        tip: x, y [px] of a point on the moving part, far from its pivot.
        at_s: time in the video [s] of the frame that ``pivot``, ``template`` and ``tip`` point at;
            the first one where None. Each of the three is enough by itself; what is not given is
            found from the motion.
        pick: which of the parts that turn, 1 for the one that explains most of what changes.
        frame_table: a frames.csv with mid-exposure times, used in place of the file's own.
        exposure_s: exposure of a row [s]; found from motion blur where it and ``readout_s`` are
            None.
        readout_s: time from the first row to the last [s], below zero where the last comes first.
        camera: lens and plane as calibrated; the plane is found from the swing where None.
        beside: the track of another part of the same video; a second one is looked for beside it.
        textured: only a part with texture counts, as where nobody asked for one.
        marker_family: kind of marker, for method "marker".
        marker_id: its number; None takes the marker that moves farthest.

    >>> TrackOptions(method="match", pivot=(320.0, 240.0)).method
    'match'
    """

    method: str = "refine"
    pivot: tuple[float, float] | None = None
    template: Box | None = None
    tip: tuple[float, float] | None = None
    at_s: float | None = None
    pick: int = 1
    frame_table: Path | None = None
    exposure_s: float | None = None
    readout_s: float | None = None
    camera: CameraGeometry | None = None
    beside: Track | None = None
    textured: bool = False
    marker_family: MarkerFamily = "aruco"
    marker_id: int | None = None

    @property
    def pointed(self) -> bool:
        """Whether the user says which part is meant."""
        return any(hint is not None for hint in (self.pivot, self.template, self.tip)) or (
            self.pick > 1
        )
