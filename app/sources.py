"""Recordings as commands take them: loaded, and tracked first where only the video is there."""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from servosight.app.output import Report, progress

if TYPE_CHECKING:
    from servosight.models.recording import Recording
    from servosight.models.recording_io import RecordingFolder
    from servosight.tracking.calibrate_view import Camera
    from servosight.tracking.markers import Family
    from servosight.tracking.track import Track

DEG_PER_RAD = math.degrees(1.0)
DOUBT = 1.5
"""Overshoot and damping change the ratio of the two ranges by about as much."""


def load(paths: Sequence[Path], args: argparse.Namespace) -> list[Recording]:
    """All recordings in order, each horn's behind its surface's, with the given pulse widths."""
    from servosight.models.recording import views
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
    return views(recordings)


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


@dataclass(frozen=True)
class Part:
    """What the user points at: pivot and box on the first frame [px], each found where None."""

    pivot: tuple[float, float] | None = None
    template: tuple[int, int, int, int] | None = None


@dataclass(frozen=True)
class Parts:
    """The surface and, where one is wanted, the part beside it, such as the horn."""

    surface: Part = Part()
    second: Part | None = None


def track_folder(
    folder: RecordingFolder,
    output: Path | None = None,
    *,
    parts: Parts = Parts(),
    method: Literal["match", "refine"] = "refine",
    camera: Camera | None = None,
    light_px: tuple[float, float] | None = None,
    marker: tuple[Family, int | None] | None = None,
) -> list[Track]:
    """Track a recording's video and write its ``angle.csv``, on the command's clock.

    Where the surface lies in the picture goes beside it, into track.toml. ``camera`` is a
    calibration, in place of recording.toml's own; ``light_px`` a light that shows the command;
    ``marker`` one to follow instead of the surface's own print, by family and number.
    """
    from servosight.app.clock import known_camera, set_keys, video_offset
    from servosight.app.geometry import Geometry
    from servosight.models.errors import InputError
    from servosight.models.shared_error import write_shared

    if folder.video is None:
        raise InputError(
            f"{folder.path}: holds no video, expected video.mkv or another container; add it, or "
            f"name the video file itself"
        )
    settings = folder.settings
    place = output or folder.angle
    clock: list[tuple[float, str]] = []

    def offset_s(surface: Track) -> float:
        clock.append(video_offset(folder, surface, light_px))
        return clock[0][0]

    tracks = track_video(
        folder.video,
        place,
        parts=parts,
        method=method,
        offset_s=offset_s,
        camera=camera or known_camera(folder),
        marker=marker,
        scale=settings.unit_scale,
        frame_table=folder.frames,
        exposure_s=settings.exposure_s if settings.shutter_told else None,
        readout_s=settings.readout_s if settings.shutter_told else None,
    )
    surface, (later_s, note) = tracks[0], clock[0]
    if place == folder.angle:
        rows, shared = surface.measured, surface.shared_deg
        told = None if shared is None else shared[rows]
        write_shared(folder.path, surface.time_s[rows] + later_s, told, settings.unit_scale)
        Geometry.of(surface, folder.video).save(folder.path)
        if surface.shutters is not None and surface.shutters.note is not None:
            found_s = float(surface.shutters.exposures_s[0])
            set_keys(folder.path / "recording.toml", found_exposure_s=f"{found_s:.6f}")
    return [replace(surface, notes=(*surface.notes, note)), *tracks[1:]]


def track_video(
    video: Path,
    output: Path,
    *,
    parts: Parts = Parts(),
    method: Literal["match", "refine"] = "refine",
    offset_s: Callable[[Track], float] = lambda surface: 0.0,
    scale: float = 1.0,
    marker: tuple[Family, int | None] | None = None,
    **known: Any,
) -> list[Track]:
    """Track a video, write ``output`` and, for a second part, horn.csv beside it.

    ``offset_s`` tells from the surface's track what to add to the video's times; ``scale`` is the
    recording's unit_scale, and ``known`` what ``tracking.track`` takes of times and camera.
    """
    from servosight.tracking.markers import track_marker
    from servosight.tracking.track import track

    found: list[Track] = []
    if marker is not None:
        with progress(f"tracking {video}") as show:
            found.append(
                track_marker(
                    video,
                    *marker,
                    pivot=parts.surface.pivot,
                    progress=lambda done: show("frames", done),
                    **known,
                )
            )
    for part in (parts.surface, parts.second):
        if part is None or marker is not None:
            continue
        title = f"tracking {video}" if not found else f"tracking {video}, second part"
        with progress(title) as show:
            found.append(
                track(
                    video,
                    pivot=part.pivot,
                    template=part.template,
                    method=method,
                    beside=found[0] if found else None,
                    progress=_paced(show),
                    **known,
                )
            )
    # Both are measured before either is written: they belong together.
    later_s = offset_s(found[0])
    for name, one in zip((output.name, "horn.csv"), found, strict=False):
        _write_track(output.with_name(name), one, later_s, scale)
    return found


def _paced(show: Report) -> Callable[[int, int], None]:
    """A bar with frames a second, counted from the first frame that was measured."""
    began = time.perf_counter()

    def report(done: int, total: int) -> None:
        nonlocal began
        if done == 1:
            began = time.perf_counter()
        pace = (done - 1) / max(time.perf_counter() - began, 1e-9)
        show(f"{pace:.0f} frames/s", done, total)

    return report


def _write_track(path: Path, track: Track, offset_s: float, scale: float) -> None:
    """Write ``time_s,angle_deg,sigma_deg`` of the frames that measured the angle.

    The others are left out: a wide sigma would count as noise of the rest.
    """
    from servosight.models.recording_io import write_angle

    rows = track.measured
    write_angle(
        path,
        track.time_s[rows] + offset_s,
        track.angle_deg[rows] / scale,
        track.sigma_deg[rows] / abs(scale),
    )
