"""Part and background as one model, for footage as people film it: where ``refine`` finds nothing.

No features, no texture and no camera at rest are needed; less exact, some hundredths of a degree.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.core import Array, FrameProgress, Image, Mask
from servosight.tracking.composite import FoundPart, PartMeter, PoseFit, SteadySample, find_parts
from servosight.tracking.core import PICTURE, Box, Flag, Track, TrackOptions, TrackRefused
from servosight.tracking.drawing import refusal_picture
from servosight.tracking.methods._verified import verify
from servosight.tracking.uncertainty import gaps
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import Film, frames

_LEAST_FRAMES = 12
_LEAST_EXPLAINED = 0.65  # of a sampled picture's change: else a hand or a shadow is as likely
_ALIGNMENT_PX = 0.2  # of the small pictures: what shake and codec leave of a part's place
_ARM = 0.7  # of the largest radius: the mean distance of what determines the angle
_COVERED = 0.75


def composite(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """The angle of the part that explains most of what changes while the camera rests.

    ``TrackRefused`` where there is none, or the frames do not confirm it.
    """
    sample = FrameSample(_as_it_is)
    for _ in sample.watch(frames(film.path)):
        pass
    steady = SteadySample.of(sample)
    if len(steady.pictures) < _LEAST_FRAMES:
        raise TrackRefused(
            f"{film.path}: the camera rests for too short a time; expected half a second at least "
            "in which it stays in place, cut the video or mount the camera.",
            refusal_picture(film.images),
        )
    given = options.pivot
    pivot = None if given is None else (np.array(given) + 0.5) * steady.scale - 0.5
    parts = find_parts(steady.pictures, pivot)
    if not parts or parts[0].explained < _LEAST_EXPLAINED:
        raise TrackRefused(
            f"{film.path}: nothing that turns explains what changes in the picture; expected a "
            "part that turns in full view, point at it with --pivot X,Y and --template X,Y,W,H.",
            refusal_picture(film.images, _pivot_of(parts, steady.scale)),
        )
    meter = PartMeter.of(steady, parts[0], given is not None)
    first, last = int(steady.index[0]), int(steady.index[-1])
    if last + 2 * sample.stride > film.header.count:  # the sample's stride ends before the file
        last = film.header.count
    stamps, fits = [], []
    for frame, fit in meter.measured(frames(film.path), first, last):
        stamps.append(frame.time_s)
        fits.append(fit)
        if progress is not None:
            progress(frame.index + 1, film.header.count)
    inside = np.arange(len(fits)) >= first
    inside &= np.arange(len(fits)) <= last
    track = _track(
        film, options, meter, np.array(stamps), fits, _notes(film, parts, stamps, inside)
    )
    seen = replace(sample, index=steady.index.tolist(), pictures=list(steady.pictures))
    line = _full(meter.outline(_first(fits)), steady.scale)
    verify(film, options, track, np.array(track.pivot_px), line, seen, inside)
    return track


def _as_it_is(image: Image) -> Image:
    return image


def _full(points: Array, scale: float) -> Array:
    """Points of the small pictures in the video's own pixels."""
    return np.asarray((points + 0.5) / scale - 0.5)


def _pivot_of(parts: list[FoundPart], scale: float) -> tuple[float, float] | None:
    """Of the best part, in the video's own pixels."""
    if not parts:
        return None
    x, y = _full(np.array(parts[0].pivot_px), scale)
    return float(x), float(y)


def _first(fits: list[PoseFit | None]) -> float:
    return next((fit.angle_rad for fit in fits if fit is not None), 0.0)


def _notes(
    film: Film, parts: list[FoundPart], stamps: list[float], inside: Mask
) -> tuple[str, ...]:
    notes = ["part and background as one model: for footage in which no textured part is found"]
    if not inside.all():
        first, last = np.flatnonzero(inside)[[0, -1]]
        notes.append(
            f"measured from {stamps[first]:.2f} to {stamps[last]:.2f} s, where the camera stays in "
            "place; the rest is left out"
        )
    return (*notes, *film.notes(stamps))


def _track(
    film: Film, options: TrackOptions, meter: PartMeter, stamps_s: Array,
    fits: list[PoseFit | None], notes: tuple[str, ...],
) -> Track:  # fmt: skip
    """The track of frames with these presentation times (frames,) and fits."""
    found = np.array([fit is not None for fit in fits])
    known = np.flatnonzero(found)
    if known.size == 0:
        raise TrackRefused(
            f"{film.path}: the part was found in none of {len(fits)} frames; expected it in most "
            "of them, point at it with --pivot X,Y and --template X,Y,W,H.",
            refusal_picture(film.images),
        )
    angle = np.full(len(fits), np.nan)
    angle[found] = np.unwrap([fit.angle_rad for fit in fits if fit is not None])
    sigma = np.array([_sigma(fit, meter) if fit is not None else np.nan for fit in fits])
    spread = max(float(np.ptp(angle[found])) / np.sqrt(12.0), np.deg2rad(1.0))
    last = known[np.clip(np.searchsorted(known, np.arange(len(fits)), "right") - 1, 0, None)]
    middle_s = film.shutters.middle_s if film.shutters is not None else 0.0
    time_s = film.times(stamps_s.tolist(), middle_s)
    covered = np.array([fit is not None and fit.kept < _COVERED for fit in fits])
    flags = np.where(found, np.where(covered, Flag.COVERED, Flag.NONE), Flag.LOST).astype(np.uint8)
    flags |= np.where(gaps(time_s), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    scale = meter.steady.scale
    outline = _full(meter.outline(_first(fits)), scale)
    x, y = _full(meter.pivot_px, scale)
    return Track(
        video=film.path,
        method=options.method,
        time_s=time_s,
        angle_deg=np.rad2deg(angle[last] - angle[known[0]]),
        sigma_deg=np.rad2deg(np.where(found, sigma, spread)),
        flags=flags,
        pivot_px=(float(x), float(y)),
        template_px=_box(outline, film.images[0].shape),
        outline_px=outline,
        plane=PICTURE,
        notes=notes,
        shutters=film.shutters,
    )


def _sigma(fit: PoseFit, meter: PartMeter) -> float:
    """Sigma of an angle [rad]: of its residuals, and of what the camera's motion leaves."""
    share = max(fit.kept, 0.2)
    place_px = np.hypot(_ALIGNMENT_PX, meter.doubt_px)
    return float(np.hypot(fit.sigma_rad, place_px / (_ARM * meter.radius_px)) / share)


def _box(outline: Array, shape: tuple[int, ...]) -> Box:
    low = np.clip(np.floor(outline.min(0)), 0, np.array(shape[1::-1]) - 1).astype(int)
    high = np.clip(np.ceil(outline.max(0)), low + 1, shape[1::-1]).astype(int)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])
