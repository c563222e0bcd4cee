"""Recordings as commands take them: loaded, and tracked first where only the video is there."""

from __future__ import annotations

import argparse
import hashlib
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from servosight.app.output import Report, progress

if TYPE_CHECKING:
    from servosight.models.core import Recording
    from servosight.models.io import RecordingFolder
    from servosight.tracking.calibration import Camera
    from servosight.tracking.methods import Family
    from servosight.tracking.track import Track

DEG_PER_RAD = math.degrees(1.0)
HORN = "horn.csv"
DOUBT = 1.5
"""Overshoot and damping change the ratio of the two ranges by about as much."""


def load(paths: Sequence[Path], args: argparse.Namespace) -> list[Recording]:
    """All recordings in order, each horn's behind its surface's, with the given pulse widths."""
    from servosight.models.core import check_path, views
    from servosight.models.io import inspect_folder, load_recording

    recordings = []
    for path in paths:
        check_path(path)
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
    from servosight.app.geometry import Geometry, digest
    from servosight.models import io as shared_error
    from servosight.models.core import InputError
    from servosight.models.io import write_shared

    if folder.video is None:
        raise InputError(
            f"{folder.path}: holds no video, expected video.mkv or another container; add it, or "
            f"name the video file itself"
        )
    settings = folder.settings
    place = output or folder.angle
    tracks = measure(
        folder.video,
        parts=parts,
        method=method,
        camera=camera or known_camera(folder),
        marker=marker,
        frame_table=folder.frames,
        exposure_s=settings.exposure_s if settings.shutter_told else None,
        readout_s=settings.readout_s if settings.shutter_told else None,
    )
    surface = tracks[0]
    later_s, note = video_offset(folder, surface, light_px)
    scale = settings.unit_scale
    if place == folder.angle:
        if surface.shutters is not None and surface.shutters.note is not None:
            found_s = float(surface.shutters.exposures_s[0])
            set_keys(folder.path / "recording.toml", found_exposure_s=f"{found_s:.6f}")
        rows, shared = surface.measured, surface.shared_deg
        told = None if shared is None else shared[rows]
        # angle.csv comes last: as long as it is missing, the recording is tracked again.
        write_shared(folder.path, surface.time_s[rows] + later_s, told, scale)
        written = {shared_error.NAME: digest(folder.path / shared_error.NAME)}
        written |= {
            name: hashlib.sha256(_table(track, later_s, scale).encode()).hexdigest()
            for name, track in zip((place.name, HORN), tracks, strict=False)
        }
        Geometry.of(surface, folder.video).save(folder.path, written)
    _write_tracks(place, tracks, later_s, scale)
    return [replace(surface, notes=(*surface.notes, note)), *tracks[1:]]


def track_video(video: Path, output: Path, **options: Any) -> list[Track]:
    """Track a video, write ``output`` and, for a second part, horn.csv beside it.

    ``options`` are those of :func:`measure`.
    """
    tracks = measure(video, **options)
    _write_tracks(output, tracks)
    return tracks


def measure(
    video: Path,
    *,
    parts: Parts = Parts(),
    method: Literal["match", "refine"] = "refine",
    marker: tuple[Family, int | None] | None = None,
    **known: Any,
) -> list[Track]:
    """Track the surface in a video and, where one is wanted, a second part.

    ``known`` is what ``tracking.track`` takes of times and camera.
    """
    from servosight.tracking.methods import track_marker
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
    return found


def _write_tracks(
    output: Path, tracks: Sequence[Track], later_s: float = 0.0, scale: float = 1.0
) -> None:
    """Write each part's angle, the surface's to ``output``, which comes last."""
    from servosight.models.core import write_text

    for name, track in reversed(list(zip((output.name, HORN), tracks, strict=False))):
        write_text(output.with_name(name), _table(track, later_s, scale))


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


def _table(track: Track, later_s: float, scale: float) -> str:
    """``time_s,angle_deg,sigma_deg`` of the frames that measured the angle, as CSV.

    ``later_s`` is added to the times. Other frames are left out: a wide sigma would count as noise
    of the rest.
    """
    from servosight.models.io import angle_text

    rows = track.measured
    return angle_text(
        track.time_s[rows] + later_s,
        track.angle_deg[rows] / scale,
        track.sigma_deg[rows] / abs(scale),
    )
