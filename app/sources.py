"""Recordings as commands take them: loaded, and tracked first where only the video is there."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from servosight.app.output import progress

if TYPE_CHECKING:
    from servosight.models.recording import Recording
    from servosight.models.recording_io import RecordingFolder
    from servosight.tracking.track import Track

DEG_PER_RAD = math.degrees(1.0)
DOUBT = 1.5
"""Overshoot and damping change the ratio of the two ranges by about as much."""


def load(paths: Sequence[Path], args: argparse.Namespace) -> list[Recording]:
    """All recordings in order, with the command line's scale for pulse widths."""
    from servosight.models.recording_io import inspect_folder, load_recording

    recordings = []
    for path in paths:
        if path.is_dir():
            folder = inspect_folder(path)
            if folder.needs_tracking:
                track_folder(folder)
        recording = load_recording(path, deg_per_us=args.deg_per_us, neutral_us=args.neutral_us)
        recordings.append(recording)
        hint = unit_hint(recording)
        if hint is not None:
            print(f"note: {path}: {hint}", file=sys.stderr)
    return recordings


def unit_hint(recording: Recording) -> str | None:
    """A doubt about radians; no refusal, for a servo may well move its surface that little."""
    import numpy as np

    ratio = recording.moved_range_deg / float(np.ptp(recording.command_deg))
    for column, factor in (("angle", 1.0 / DEG_PER_RAD), ("command", DEG_PER_RAD)):
        if factor / DOUBT < ratio < factor * DOUBT:
            return (
                f"the angle moves {ratio:.3g} times as far as the command; if the {column} is in "
                f"radians, name its column {column}_rad"
            )
    return None


def track_folder(
    folder: RecordingFolder,
    output: Path | None = None,
    *,
    pivot: tuple[float, float] | None = None,
    template: tuple[float, float, float, float] | None = None,
    method: Literal["match", "refine"] = "refine",
) -> Track:
    """Track a recording's video and write its ``angle.csv``, on the command's clock.

    Frames that measured nothing are left out: a wide sigma would count as noise of the rest.
    Where the surface lies in the picture goes beside it, into track.toml.
    """
    from servosight.app.geometry import Geometry
    from servosight.models.errors import InputError

    if folder.video is None:
        raise InputError(
            f"{folder.path}: holds no video, expected video.mkv or another container; add it, or "
            f"name the video file itself"
        )
    settings = folder.settings
    result = track_video(
        folder.video,
        pivot=pivot,
        template=template,
        method=method,
        frame_table=folder.frames,
        exposure_s=settings.exposure_s,
        readout_s=settings.readout_s,
    )
    time_s = result.time_s + settings.video_offset_s
    place = output or folder.angle
    write_track(place, result, time_s=time_s, scale=settings.unit_scale)
    if place == folder.angle:
        Geometry.of(result, folder.video).save(folder.path)
    return result


def track_video(video: Path, **options: Any) -> Track:
    """Track a video with a line of progress."""
    from servosight.tracking.track import track

    with progress(f"tracking {video}") as show:
        return track(video, progress=lambda frames: show("frames", frames), **options)


def write_track(path: Path, track: Track, *, time_s: Any = None, scale: float = 1.0) -> None:
    """Write ``time_s,angle_deg,sigma_deg`` of the frames that measured the angle.

    ``scale`` is the recording's unit_scale.
    """
    from servosight.models.recording_io import write_angle

    times = track.time_s if time_s is None else time_s
    rows = track.measured
    write_angle(
        path, times[rows], track.angle_deg[rows] / scale, track.sigma_deg[rows] / abs(scale)
    )
