"""Part and background as one model, for footage as people film it: where ``refine`` finds nothing.

No features, no texture and no camera at rest are needed; less exact, some hundredths of a degree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import cv2
import numpy as np

from servosight.models.core import Array, FrameProgress, Image, Mask
from servosight.tracking.acquisition import POINT, pointed_box
from servosight.tracking.composite import (
    TRUST,
    FoundPart,
    Hint,
    PartMeter,
    PoseFit,
    SteadySample,
    distrust,
    find_parts,
    found_about,
    outline_of,
)
from servosight.tracking.core import (
    PICTURE,
    Box,
    Candidate,
    Flag,
    Track,
    TrackOptions,
    TrackRefused,
    outline_at,
)
from servosight.tracking.drawing import SeenPart, refusal_picture
from servosight.tracking.methods._verified import verify
from servosight.tracking.uncertainty import gaps
from servosight.tracking.verification import FrameSample, small
from servosight.tracking.video import Film, frame_at, frames

_LONG_SIDE_PX, _CHECKED_PX = 960, 480
_LEAST_FRAMES = 12
_LEAST_POINTED = 0.15
_ALIGNMENT_PX = 0.2  # of the small pictures: what shake and codec leave of a part's place
_ARM = 0.7  # of the largest radius: the mean distance of what determines the angle
_COVERED = 0.75
_ANEW = 2
_FAR_OFF = 5.0  # times the median: a hand before one side


def composite(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """The angle of the part that explains most of what changes while the camera rests.

    With hints, of the part that these point at. ``TrackRefused`` where there is none, or the frames
    do not confirm it.
    """
    sample = FrameSample(_as_it_is, _LONG_SIDE_PX)
    stamps_s = np.array([frame.time_s for frame in sample.watch(frames(film.path))])
    steady = SteadySample.of(sample)
    if len(steady.pictures) < _LEAST_FRAMES:
        raise TrackRefused(
            f"{film.path}: the camera rests for too short a time; expected half a second at least "
            "in which it stays in place, cut the video or mount the camera.",
            refusal_picture(film.images),
        )
    hint = _hint(film, options, steady, stamps_s)
    parts = find_parts(steady.pictures, hint)
    meter = _chosen(film, options, steady, parts, stamps_s, hint)
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
    candidates = tuple(_candidate(part, steady) for part in parts)
    notes = _notes(film, candidates, options.pick, stamps, inside)
    track = replace(
        _track(film, options, meter, np.array(stamps), fits, notes), candidates=candidates
    )
    seen = replace(sample, index=steady.index.tolist(), pictures=list(steady.pictures))
    seen = seen.smaller(_CHECKED_PX)
    line = _full(meter.outline(_first(fits)), steady.scale)
    shown = outline_at(track, float(track.angle_deg[steady.reference_index]))
    draw = partial(_drawn, film, steady, stamps_s, [SeenPart(track.pivot_px, shown)])
    verify(film, options, track, np.array(track.pivot_px), line, seen, inside, draw)
    apart_deg = float(np.rad2deg(meter.apart_rad(fits)))
    track = replace(track, sigma_deg=np.hypot(track.sigma_deg, apart_deg))
    why = distrust(apart_deg, track.sigma_deg[track.found], fits, options.pointed)
    if why is not None:
        x, y = track.pivot_px
        sentence = f"{film.path}: the part about {x:.0f},{y:.0f} {why}, {POINT}."
        raise TrackRefused(sentence, draw(), measured=True)
    return track


def _hint(film: Film, options: TrackOptions, steady: SteadySample, stamps_s: Array) -> Hint | None:
    """What the user points at, if anything."""
    box = pointed_box(options, film.images[0].shape)
    if options.pivot is None and box is None:
        return None
    frame = film.images[0]
    if options.at_s is not None:
        frame = frame_at(film.path, options.at_s).image
    index = int(np.argmin(np.abs(stamps_s - (options.at_s or stamps_s[0]))))
    return Hint.of(steady, small(frame, steady.scale), index, options.pivot, box)


def _chosen(
    film: Film, options: TrackOptions, steady: SteadySample, parts: list[FoundPart],
    stamps_s: Array, hint: Hint | None,
) -> PartMeter:  # fmt: skip
    """The part to measure; ``TrackRefused``, with all of them drawn, where it is not there."""
    least = _LEAST_POINTED if options.pointed else TRUST.least_explained
    if len(parts) >= options.pick and parts[options.pick - 1].explained >= _LEAST_POINTED:
        part, meter = _settled(steady, parts[options.pick - 1], hint)
        if part.explained >= least:
            return meter
    if options.pick > 1:
        why = (
            f"--pick is {options.pick}, and {len(parts)} parts that may turn are found; expected "
            "the number of one of them, or point at it with --tip X,Y"
        )
    elif options.pointed:
        why = (
            "nothing that turns is found at the place pointed at; expected the pivot, a point of "
            "the part or a box around it on the frame --at SECONDS"
        )
    else:
        why = (
            "nothing that turns explains what changes in the picture; expected a part that turns "
            f"in full view, {POINT}"
        )
    seen = [_seen(part, steady) for part in parts]
    raise TrackRefused(f"{film.path}: {why}.", _drawn(film, steady, stamps_s, seen))


def _settled(
    steady: SteadySample, part: FoundPart, hint: Hint | None
) -> tuple[FoundPart, PartMeter]:
    """The part and its meter, learnt anew where its pivot turns out to be elsewhere."""
    meter = PartMeter.of(steady, part)
    for _ in range(_ANEW):
        # A pixel of the pictures in which the part was found.
        if np.hypot(*(meter.pivot_px - part.pivot_px)) < 1.0 / part.scale:
            break
        better = found_about(steady.pictures, meter.pivot_px, hint)
        if better is None:
            break
        part, meter = better, PartMeter.of(steady, better)
    return part, meter


def _drawn(film: Film, steady: SteadySample, stamps_s: Array, parts: Sequence[SeenPart]) -> Image:
    """Parts on the picture that all frames were aligned with."""
    height, width = film.images[0].shape

    def large(picture: Image) -> Image:
        return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_LINEAR))

    others = np.clip(np.round(steady.pictures[:: 1 + len(steady.pictures) // 24]), 0, 255)
    images = [large(steady.reference), *(large(one.astype(np.uint8)) for one in others)]
    return refusal_picture(images, parts, float(stamps_s[steady.reference_index]))


def _seen(part: FoundPart, steady: SteadySample) -> SeenPart:
    outline = _full(outline_of(part, steady), steady.scale)
    return SeenPart(_candidate(part, steady).pivot_px, outline)


def _candidate(part: FoundPart, steady: SteadySample) -> Candidate:
    x, y = _full(np.array(part.pivot_px), steady.scale)
    return Candidate(pivot_px=(float(x), float(y)), explained=round(part.explained, 3))


def _as_it_is(image: Image) -> Image:
    return image


def _full(points: Array, scale: float) -> Array:
    """Points of the small pictures in the video's own pixels."""
    return np.asarray((points + 0.5) / scale - 0.5)


def _first(fits: list[PoseFit | None]) -> float:
    return next((fit.angle_rad for fit in fits if fit is not None), 0.0)


def _notes(
    film: Film, candidates: Sequence[Candidate], pick: int, stamps: list[float], inside: Mask
) -> tuple[str, ...]:
    notes = ["part and background as one model: for footage in which no textured part is found"]
    others = [number for number in range(1, len(candidates) + 1) if number != pick]
    if others:
        (x, y), explained = candidates[others[0] - 1].pivot_px, candidates[others[0] - 1].explained
        notes.append(
            f"the part about {x:.0f},{y:.0f} px may be meant as well: it explains "
            f"{explained:.0%} of what changes, the one measured "
            f"{candidates[pick - 1].explained:.0%}; --pick {others[0]} takes it"
        )
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
            f"of them, {POINT}.",
            refusal_picture(film.images),
        )
    angle = np.full(len(fits), np.nan)
    angle[found] = np.unwrap([fit.angle_rad for fit in fits if fit is not None])
    sigma = np.array([_sigma(fit, meter) if fit is not None else np.nan for fit in fits])
    sigma = np.hypot(sigma, _apart([fit.sides_rad for fit in fits if fit is not None]))
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


def _apart(sides_rad: Sequence[float]) -> float:
    """Error of an angle [rad] that differs from angle to angle, as of a shadow beside the part.

    It shifts one side of the part, so that both sides give angles whose difference varies; the
    error of the angle is half of that.
    """
    away = np.abs(np.array(sides_rad) - np.median(sides_rad))
    limited = np.minimum(away, _FAR_OFF * np.median(away))
    return 0.5 * float(np.sqrt(np.mean(limited**2)))


def _box(outline: Array, shape: tuple[int, ...]) -> Box:
    low = np.clip(np.floor(outline.min(0)), 0, np.array(shape[1::-1]) - 1).astype(int)
    high = np.clip(np.ceil(outline.max(0)), low + 1, shape[1::-1]).astype(int)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])
