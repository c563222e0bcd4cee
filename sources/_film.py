"""The video of a recording tracked: angles in memory, or written into its folder."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import InputError, StageProgress, either, silent

if TYPE_CHECKING:
    from servosight.models.io import RecordingFolder
    from servosight.sources._clock import Offset
    from servosight.tracking.core import CameraGeometry, MarkerFamily, Track

HORN = "horn.csv"


@dataclass(frozen=True)
class Part:
    """What the user points at, on the frame at ``at_s`` (the first where None): pivot, box and a
    point of the part [px], each found where None; or its place among those that turn."""

    pivot: tuple[float, float] | None = None
    template: tuple[int, int, int, int] | None = None
    tip: tuple[float, float] | None = None
    at_s: float | None = None
    pick: int = 1

    def __post_init__(self) -> None:
        if self.at_s is not None and not (self.pivot or self.template or self.tip):
            raise InputError(
                f"track: {either(f'at_s={self.at_s:g}', f'--at {self.at_s:g}')} points at nothing, "
                f"expected a place on that frame; give --pivot, --template or --tip as well"
            )


@dataclass(frozen=True)
class Parts:
    """The surface and, where one is wanted, the part beside it, such as the horn.

    ``linkage``: a horn with texture counts where nobody asked for it.
    """

    surface: Part = Part()
    second: Part | None = None
    linkage: bool = False


@dataclass(frozen=True)
class Tracking:
    """How to track; the defaults find all by themselves.

    ``camera`` is a calibration, in place of recording.toml's own; ``light_px`` a light that shows
    the command; ``marker`` one to follow instead of the surface's own print, by family and number.
    """

    parts: Parts = Parts()
    method: str = "refine"
    camera: CameraGeometry | None = None
    light_px: tuple[float, float] | None = None
    marker: tuple[MarkerFamily, int | None] | None = None


def follow_folder(
    folder: RecordingFolder,
    how: Tracking = Tracking(),
    progress: StageProgress = silent,
    **given: Any,
) -> tuple[list[Track], Offset]:
    """Track a recording's video: each part on the video's clock, and that clock's offset.

    ``given`` are ``TrackOptions`` that go before what the folder says. Nothing is written. Raises
    InputError where the folder holds no video.
    """
    return list(_followed(folder, how, progress, **given))[-1]


def video_of(folder: RecordingFolder) -> Path:
    """The video of a recording; InputError where the folder holds none."""
    if folder.video is None:
        raise InputError(
            f"{folder.path}: holds no video, expected video.mkv or another container; add it, or "
            f"name the video file itself"
        )
    return folder.video


def _followed(
    folder: RecordingFolder, how: Tracking, progress: StageProgress, **given: Any
) -> Iterator[tuple[list[Track], Offset]]:
    """As ``follow_folder``, once more after each part."""
    from servosight.sources._clock import known_camera, video_offset

    video = video_of(folder)
    settings = folder.settings
    known = {
        "frame_table": folder.frames,
        "exposure_s": settings.exposure_s if settings.shutter_given else None,
        "readout_s": settings.readout_s if settings.shutter_given else None,
    }
    how_known = replace(how, camera=how.camera or known_camera(folder))
    offset: Offset | None = None
    for tracks in measured(video, how_known, progress, **{**known, **given}):
        offset = offset or video_offset(folder, tracks[0], how.light_px)
        yield [replace(tracks[0], notes=(*tracks[0].notes, offset.note)), *tracks[1:]], offset


def track_folder(
    folder: RecordingFolder,
    output: Path | None = None,
    how: Tracking = Tracking(),
    progress: StageProgress = silent,
) -> list[Track]:
    """Track a recording's video and write its ``angle.csv``, on the command's clock.

    Where the surface lies in the picture goes beside it, into track.toml. The first part is written
    before a second one is looked for.
    """
    tracks: list[Track] = []
    for tracks, offset in _followed(folder, how, progress):
        _keep(folder, output or folder.angle, tracks, offset)
    return tracks


def _keep(folder: RecordingFolder, place: Path, tracks: list[Track], offset: Offset) -> None:
    """Write what was tracked of a recording's video."""
    from servosight.models.io import SHARED_FILE, set_keys, write_shared
    from servosight.sources._surface import Geometry, digest

    assert folder.video is not None
    offset.keep(folder)
    surface, later_s, scale = tracks[0], offset.offset_s, folder.settings.unit_scale
    if place == folder.angle:
        if surface.shutters is not None and surface.shutters.note is not None:
            found_s = float(surface.shutters.exposures_s[0])
            set_keys(folder.path / "recording.toml", found_exposure_s=round(found_s, 6))
        _note_lost(folder, surface)
        rows, shared = surface.measured, surface.shared_deg
        shared_rows = None if shared is None else shared[rows]
        # angle.csv comes last: as long as it is missing, the recording is tracked again.
        write_shared(folder.path, surface.time_s[rows] + later_s, shared_rows, scale)
        written = {SHARED_FILE: digest(folder.path / SHARED_FILE)}
        written |= {
            name: hashlib.sha256(_table(track, later_s, scale).encode()).hexdigest()
            for name, track in zip((place.name, HORN), tracks, strict=False)
        }
        Geometry.of(surface, folder.video).save(folder.path, written)
    _write_tracks(place, tracks, later_s, scale)


def _note_lost(folder: RecordingFolder, surface: Track) -> None:
    """Keep with a recording which pictures of its video are missing, for all who use its angles."""
    from servosight.models.io import set_keys

    before = folder.settings.import_notes
    others = [note for note in before if not note.startswith(f"{surface.video.name}: ")]
    notes = [*others, *(f"{surface.video.name}: {note}" for note in surface.lost)]
    if notes != list(before):
        set_keys(folder.path / "recording.toml", import_notes=notes)


def track_video(
    video: Path, output: Path, how: Tracking = Tracking(), progress: StageProgress = silent
) -> list[Track]:
    """Track a video, write ``output`` and, for a second part, horn.csv beside it.

    The first part is written before the second one is looked for.
    """
    tracks: list[Track] = []
    for tracks in measured(video, how, progress):
        _write_tracks(output, tracks)
    return tracks


def measured(
    video: Path, how: Tracking = Tracking(), progress: StageProgress = silent, **known: Any
) -> Iterator[list[Track]]:
    """A part of a video; then, where one is wanted or found, surface and horn, in this order.

    The horn may be the part that was found first. A second part that is refused raises
    ``TrackRefused`` after the first was given. ``known`` are the ``TrackOptions`` of times and
    exposure.
    """
    from servosight.tracking.core import TrackOptions, TrackRefused
    from servosight.tracking.linkage import find_linkage, linked
    from servosight.tracking.methods import method_of
    from servosight.tracking.track import track_film
    from servosight.tracking.video import open_film

    surface, second = how.parts.surface, how.parts.second
    options = TrackOptions(
        method=how.method,
        pivot=surface.pivot,
        template=surface.template,
        tip=surface.tip,
        at_s=surface.at_s,
        pick=surface.pick,
        camera=how.camera,
        **known,
    )
    if how.marker is not None:
        family, number = how.marker
        options = replace(options, method="marker", marker_family=family, marker_id=number)
    method_of(options.method)  # before the video is read through
    film = open_film(video, options)
    first = track_film(film, options, _paced(progress, ""))
    yield [first]
    if how.marker is not None:
        return
    second_part = _paced(progress, "second part, ")
    if second is None:
        found = find_linkage(first, film, options, second_part) if how.parts.linkage else None
        if found is not None:
            yield list(found)
        return
    beside = replace(
        options, pivot=second.pivot, template=second.template, tip=None, at_s=None, pick=1,
        beside=first,
    )  # fmt: skip
    try:
        other = track_film(film, beside, second_part)
    except TrackRefused as refused:
        sentence = f"{str(refused).rstrip('.')}; this is of the second part, the first is measured."
        raise TrackRefused(sentence, refused.draw, refused.measured) from refused
    pointed = second.pivot is not None or second.template is not None
    yield list(linked(first, other, film, given=pointed))


def _write_tracks(
    output: Path, tracks: Sequence[Track], later_s: float = 0.0, scale: float = 1.0
) -> None:
    """Write each part's angle, the surface's to ``output``, which comes last."""
    from servosight.models.core import write_text

    for name, track in reversed(list(zip((output.name, HORN), tracks, strict=False))):
        write_text(output.with_name(name), _table(track, later_s, scale))


def _paced(show: StageProgress, prefix: str) -> Callable[[int, int], None]:
    """Progress with frames a second, counted from the first frame that was measured."""
    began = time.perf_counter()

    def report(done: int, total: int) -> None:
        nonlocal began
        if done == 1:
            began = time.perf_counter()
        pace = (done - 1) / max(time.perf_counter() - began, 1e-9)
        show(f"{prefix}{pace:.0f} frames/s", done, total)

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
