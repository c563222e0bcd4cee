"""Where the surface is in a tracked video: kept beside angle.csv for whoever draws on a frame."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from msgspec import Meta

from servosight.models.core import Array

if TYPE_CHECKING:
    from servosight.models.core import Recording
    from servosight.tracking.core import Track


TRACK_FILE = "track.toml"
FORMAT = 1
MOST_FRAMES = 100_000_000
"""Ten days at 120 Hz."""


@dataclass(frozen=True)
class Geometry:
    """The surface in the picture at angle zero, and by what its video is known again.

    ``pivot_px`` is x, y (integer centres, y down), ``outline_px`` (points, 2) the contour,
    ``left_out`` the frames that have no row in angle.csv, ``runner_up_px`` the pivot of the part
    that may be meant as well.
    """

    frames: int
    video_bytes: int
    pivot_px: tuple[float, float]
    outline_px: Array
    left_out: tuple[int, ...] = ()
    runner_up_px: tuple[float, float] | None = None

    def frame_of(self, row: int) -> int:
        """The frame that a row of angle.csv, counted from 0, was measured in."""
        return int(np.delete(np.arange(self.frames), np.array(self.left_out, int))[row])

    @classmethod
    def of(cls, track: Track, video: Path) -> Geometry:
        """What a track found in ``video``."""
        outline = np.asarray(track.outline_px, dtype=np.float64)
        left_out = tuple(np.flatnonzero(~track.measured).tolist())
        other = track.runner_up
        return cls(
            track.frames, video.stat().st_size, track.pivot_px, outline, left_out,
            other.pivot_px if other is not None else None,
        )  # fmt: skip

    def save(self, folder: Path, written: Mapping[str, str] | None = None) -> None:
        """Write track.toml into a recording's folder, completely or not at all.

        ``written`` are the files beside it that the tracker writes, by name, with their SHA-256.
        """
        from servosight.models.core import write_text

        x, y = self.pivot_px
        points = ", ".join(f"[{x:.2f}, {y:.2f}]" for x, y in self.outline_px)
        lines = (
            f"format = {FORMAT}",
            f"frames = {self.frames}",
            f"left_out = {list(self.left_out)}",
            f"video_bytes = {self.video_bytes}",
            f"pivot_px = [{x:.4f}, {y:.4f}]",
            f"outline_px = [{points}]",
            *(
                [f"runner_up_px = [{self.runner_up_px[0]:.1f}, {self.runner_up_px[1]:.1f}]"]
                if self.runner_up_px is not None
                else []
            ),
            "[sha256]",
            *(f'"{name}" = "{digest}"' for name, digest in (written or {}).items()),
        )
        write_text(folder / TRACK_FILE, "\n".join(lines) + "\n")


def tracked_files(folder: Path) -> set[str]:
    """Names of the files in ``folder`` that the tracker wrote and nobody has changed since."""
    from servosight.models.core import InputError, read_settings

    try:
        table = read_settings(folder / TRACK_FILE)
        digests = dict(table["sha256"])
        same = {name for name, known in digests.items() if digest(folder / name) == known}
    except (InputError, OSError, KeyError, TypeError, ValueError):
        return set()
    return {*same, TRACK_FILE}


def digest(path: Path) -> str:
    """SHA-256 of a file; empty where it is missing."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def geometry_of(recording: Recording) -> Geometry | None:
    """The geometry kept beside a recording's angle; None where there is none that fits.

    It fits where video and samples are still those that were tracked: a row for each frame that
    was not left out.
    """
    from servosight.models.core import InputError, read_settings, validated

    if recording.video is None:
        return None
    file = recording.video.with_name(TRACK_FILE)
    try:
        keys = validated(read_settings(file), _SurfaceKeys, file, notes=True)
        size = recording.video.stat().st_size
    except (InputError, OSError):
        return None
    left_out = keys.left_out
    if left_out != tuple(sorted({*left_out} & {*range(keys.frames)})):
        return None
    if (keys.frames - len(left_out), keys.video_bytes) != (recording.time_s.size, size):
        return None
    outline = np.array(keys.outline_px, dtype=np.float64)
    return Geometry(keys.frames, size, keys.pivot_px, outline, left_out, keys.runner_up_px)


@dataclass(frozen=True)
class _SurfaceKeys:
    """The keys of track.toml, but for the digests."""

    frames: Annotated[int, Meta(ge=1, le=MOST_FRAMES)]
    video_bytes: int
    pivot_px: tuple[float, float]
    outline_px: Annotated[tuple[tuple[float, float], ...], Meta(min_length=3)]
    left_out: tuple[int, ...] = ()
    runner_up_px: tuple[float, float] | None = None
    format: Annotated[int, Meta(ge=FORMAT, le=FORMAT)] = FORMAT
