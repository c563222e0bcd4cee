"""Video in, angle and its sigma out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.models.core import Array, Image, InputError
from servosight.tracking.acquisition import acquire, same_view, without
from servosight.tracking.calibration import Camera, Flattened, about_hinge, flattened, view_of
from servosight.tracking.core import STILL, Method, Plane, Shutters, principal, turned
from servosight.tracking.core import Box as Box
from servosight.tracking.core import Flag as Flag
from servosight.tracking.core import Track as Track
from servosight.tracking.core import outline_at as outline_at
from servosight.tracking.fit import Fit, Stage, follow
from servosight.tracking.layers import Layered, layered_stage
from servosight.tracking.methods import Match, Refine, choose_box
from servosight.tracking.shutter import at_middle_row, find_shutter, first_pass
from servosight.tracking.surface import Surface
from servosight.tracking.uncertainty import (
    columns,
    flags_of,
    gaps,
    light_centre,
    scatter,
    shown_share,
    speeds,
    uneven,
)
from servosight.tracking.video import (
    LEAST_PX,
    Bench,
    Frame,
    Header,
    ahead,
    calm_frames,
    check,
    even_times,
    frames,
    read_frame_table,
    wander_px,
)

Progress = Callable[[int, int], None]

_AHEAD = 4
_OFF_RATE = 0.02  # between the declared rate and that of the presentation times
_EVEN = 0.1  # share of a frame time, and of frames, that an even rate may be off
_LOST_DEG = 1.0  # where a frame cannot be laid on the first
_ARM = 0.6  # of the largest radius, at which the angle is told on average


def track(
    video: Path,
    *,
    pivot: tuple[float, float] | None = None,
    template: Box | None = None,
    method: Method = "refine",
    frame_table: Path | None = None,
    exposure_s: float | None = None,
    readout_s: float | None = None,
    camera: Camera | None = None,
    beside: Track | None = None,
    progress: Progress | None = None,
) -> Track:
    """Measure the angle of the moving part in every frame of a video.

    ``pivot`` (x, y) [px] and ``template`` (x, y, width, height) on the first frame are found from
    the motion where not given. ``frame_table`` is a frames.csv with mid-exposure times, which goes
    before the file's own presentation times (start of the first row's exposure, to which half of
    ``exposure_s`` and of ``readout_s``, the time from the first row to the last, are added). Where
    neither is told, both are found from smear and shear.
    ``camera`` is what a calibration tells; the view is found from the swing where it does not.
    ``beside`` is a part of the same video that is tracked already: another one is looked for.
    ``progress`` is called with the numbers of frames done and of all. Raises ``InputError``.
    """
    times = read_frame_table(frame_table) if frame_table is not None else None
    header = check(video)
    if times is not None:
        _same_length(frame_table, len(times[0]), video, header.count)
    shutters = _told(video, exposure_s, readout_s, times[1] if times is not None else None)
    copies = header.predicting is not None
    calm = calm_frames(video)
    images = [frame.image for frame in calm]
    wander = wander_px(images)
    bench = Bench.of(images[0]) if wander > LEAST_PX else None

    def held(frame: Frame) -> Frame:
        if bench is None:
            return frame
        image, doubt_px = bench.held(frame.image)
        return replace(frame, image=image, doubt_px=doubt_px)

    images = [held(frame).image for frame in calm]
    view = view_of(images, camera) if beside is None else same_view(beside, camera)
    if beside is not None and template is None:
        images = without(images, beside)
    flat = flattened(view.plane, images[0].shape)
    surface = _acquired(video, [flat(image) for image in images], view.plane, pivot, template)
    refine = Refine.of(surface, images[0].shape)
    zero = refine.near(images[0], refine.anywhere(images[0], 0.0, np.pi), STILL)
    home_rad = zero.angle_rad if zero is not None else 0.0
    outline = turned(surface.outline_px, surface.pivot_px, home_rad)
    box = template or choose_box(outline, surface.pivot_px, flat(images[0]))
    stage: Stage
    if shutters is None and beside is not None:
        shutters = beside.shutters
    if shutters is None:
        shutters = Shutters(np.zeros(1), 0.0)
        if method == "refine":
            shutters = find_shutter(refine, first_pass(video, refine, shutters, held, copies))
    if method == "match":
        stage, home_rad = Flattened(Match(flat(images[0]), surface.pivot_px, box), flat), 0.0
    else:
        stage = layered_stage(first_pass(video, refine, shutters, held, copies), refine)

    stamps, unsteady_px, fits, exposures, repeated = [], [], [], [], []
    source = ahead(map(held, frames(video)), _AHEAD)
    tip_px = surface.grid.largest_px
    for seen in follow(stage, source, home_rad, shutters, tip_px, copies):
        stamps.append(seen.frame.time_s)
        unsteady_px.append(seen.frame.doubt_px)
        fits.append(seen.fit)
        exposures.append(seen.exposure)
        repeated.append(seen.repeated)
        if progress is not None:
            progress(seen.frame.index + 1, header.count)
    if all(fit is None for fit in fits):
        raise InputError(
            f"{video}: the surface was found in none of {len(fits)} frames; expected it in most of "
            "them, point at it with --pivot X,Y and --template X,Y,W,H."
        )
    if times is not None:
        _same_length(frame_table, len(times[0]), video, len(stamps))
        time_s = times[0]
    else:
        time_s = even_times(np.array(stamps), header.tick_s) + shutters.middle_s
    flags = np.array([flags_of(fit) for fit in fits], np.uint8)
    flags |= np.where(gaps(time_s), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    doubt = np.zeros(len(fits))
    mend = about_hinge(fits, view, pivot is not None)
    fits = mend.fits
    rolls = shutters.readout_s != 0.0
    if rolls:
        fits, doubt = at_middle_row(time_s, fits, exposures, shutters.readout_s)
    else:
        gain = np.array([fit.gain if fit else np.nan for fit in fits])
        late_s, late_doubt_s = light_centre(time_s, gain, float(np.median(shutters.exposures_s)))
    # Rows out of step leave errors that last, which no scatter shows.
    shown = 1.0 if rolls else shown_share(fits)
    angle, sigma, flags = columns(fits, flags, repeated, shown)
    if not rolls:
        speed, unsure = speeds(angle, time_s)
        angle = angle - speed * late_s
        doubt = np.hypot(speed * late_doubt_s, unsure * late_s)
    of_readout = _by_readout(angle, time_s, fits, shutters.readout_doubt_s)
    shared = principal(np.hstack([mend.shared_rad, of_readout]))
    sigma = np.sqrt(
        sigma**2
        + doubt**2
        + uneven(angle, time_s, shutters.exposures_s) ** 2
        + _shaken(np.array(unsteady_px), surface) ** 2
        + (shared**2).sum(1)
        + (scatter(angle) ** 2 if copies or bench else 0.0)
    )
    pivot_px = stage.layers.grid.pivot_px if isinstance(stage, Layered) else surface.pivot_px
    x, y = view.plane.to_picture(np.array([pivot_px]) + mend.moved_px)[0]
    return Track(
        video,
        method,
        time_s,
        np.rad2deg(angle - angle[0]),
        np.rad2deg(sigma),
        flags,
        (float(x), float(y)),
        box,
        view.plane.to_picture(outline),
        view.plane,
        (
            *(mend.notes or (view.note,)),
            *([shutters.note] if shutters.note else []),
            *_notes(header, stamps, wander),
        ),
        np.rad2deg(shared),
        shutters,
    )


def _told(
    video: Path, exposure_s: float | None, readout_s: float | None, exposures_s: Array | None
) -> Shutters | None:
    """The shutters that are told, None where nothing is; ``exposures_s`` are a frames.csv's."""
    for name, value in (("exposure_s", exposure_s), ("readout_s", readout_s)):
        if value is not None and not (np.isfinite(value) and 0.0 <= value < 10.0):
            raise InputError(
                f"{video}: {name} is {value:g}; expected seconds from 0 to 10, mend "
                f"camera.{name} in recording.toml."
            )
    if exposures_s is None and exposure_s is None and readout_s is None:
        return None
    every_s = exposures_s if exposures_s is not None else np.array([exposure_s or 0.0])
    return Shutters(every_s, readout_s or 0.0)


def _by_readout(angle: Array, time_s: Array, fits: list[Fit | None], doubt_s: float) -> Array:
    """What one sigma of the readout makes of the angles (frames, 1), but for a shift in time that
    all have; (frames, 0) where it is known."""
    if doubt_s == 0.0:
        return np.zeros((angle.size, 0))
    delay = np.array([fit.delay if fit else np.nan for fit in fits])
    apart = np.nan_to_num(delay - np.nanmean(delay))
    speed = np.gradient(angle, time_s)
    return np.asarray(speed * apart * doubt_s, np.float64)[:, None]


def _acquired(
    video: Path,
    images: list[Image],
    plane: Plane,
    pivot_px: tuple[float, float] | None,
    template: Box | None,
) -> Surface:
    """The surface as flattened pictures show it, in its plane; pivot and box are the picture's."""
    if pivot_px is not None:
        x, y = plane.of_picture(np.array([pivot_px]))[0]
        pivot_px = float(x), float(y)
    surface = acquire(video, images, pivot_px, template)
    return replace(surface, grid=replace(surface.grid, plane=plane))


def _shaken(doubt_px: Array, surface: Surface) -> Array:
    """Doubt [rad] of frames that were laid on the first one, to some pixels; (frames,)."""
    return np.minimum(doubt_px / (_ARM * surface.grid.largest_px), np.deg2rad(_LOST_DEG))


def _notes(header: Header, stamps: list[float], wander: float) -> list[str]:
    notes = []
    step_s = np.diff(stamps)
    told_hz = 1.0 / float(np.median(step_s))
    even = float(np.mean(np.abs(step_s * told_hz - 1.0) < _EVEN)) > 1.0 - _EVEN
    said_hz = header.declared_hz
    if even and said_hz is not None and abs(said_hz / told_hz - 1.0) > _OFF_RATE:
        notes.append(
            f"the file declares {said_hz:.4g} frames a second, and its presentation times say "
            f"{told_hz:.4g}: the times are used, a slowed or sped copy needs a frames.csv"
        )
    if header.predicting is not None:
        notes.append(
            f"{header.predicting} draws pictures from the ones before: what it only copied is left "
            "out, and sigma holds the scatter from frame to frame, but not an error that stays for "
            "long"
        )
    if wander > LEAST_PX:
        notes.append(
            f"the camera moved by {wander:.2g} px rms: its motion is read off the bench and taken "
            "out, which costs accuracy; a camera held fast would not need it"
        )
    return notes


def _same_length(table: Path | None, rows: int, video: Path, count: int) -> None:
    if rows != count:
        raise InputError(
            f"{table}: lists {rows} frames and {video.name} has {count}; expected one row a "
            "frame, mend or remove the table."
        )
