"""The pipeline that methods share which measure frame after frame.

Find the moving part; prepare an estimator (the method's own); follow the frames; evaluate all of
them together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array, FrameProgress, Image, InputError
from servosight.tracking.acquisition import acquire, same_view, without
from servosight.tracking.calibration import View, rectifier, view_of
from servosight.tracking.core import STILL, Box, Shutters, Track, TrackOptions, turned
from servosight.tracking.fit import AngleEstimator, follow
from servosight.tracking.methods._box import choose_box
from servosight.tracking.surface import Surface, SurfaceEstimator
from servosight.tracking.uncertainty import Measured, evaluate
from servosight.tracking.video import Film


@dataclass(frozen=True)
class Subject:
    """The moving part as the motion, or the user, shows it.

    ``view`` is how the camera sees its plane, ``rectified`` resamples pictures into that plane and
    ``first`` is the first one so. ``estimator`` measures it by its interior, ``home_rad`` is its
    angle in the first frame against the learnt ``surface``, ``outline`` (points, 2) its contour
    there in the plane, ``box`` the square on it that determines the angle best.
    """

    view: View
    rectified: Callable[[Image], Image]
    first: Image
    surface: Surface
    estimator: SurfaceEstimator
    home_rad: float
    outline: Array
    box: Box


@dataclass(frozen=True)
class Instrument:
    """What measures each frame, from ``home_rad`` in the first one.

    ``pivot`` is x, y in the plane about which it turns the part, ``shutters`` when rows are
    exposed.
    """

    estimator: AngleEstimator
    home_rad: float
    pivot: tuple[float, float]
    shutters: Shutters


Prepare = Callable[[Film, Subject], Instrument]


def track_frames(
    film: Film, options: TrackOptions, progress: FrameProgress | None, prepare: Prepare
) -> Track:
    """Track by an estimator that ``prepare`` makes for the moving part; InputError if not found."""
    film = film.stabilised()
    subject = find_subject(film, options)
    instrument = prepare(film, subject)
    measured = measure(film, subject, instrument, progress)
    time_s = film.times(measured.stamps_s, instrument.shutters.middle_s)
    angles = evaluate(
        measured,
        time_s,
        subject.view,
        instrument.shutters,
        pivot_given=options.pivot is not None,
        correlated=film.predicted or film.stabiliser is not None,
    )
    plane = subject.view.plane
    x, y = plane.to_picture(np.array([instrument.pivot]) + angles.pivot_shift_px)[0]
    shutter_notes = (instrument.shutters.note,) if instrument.shutters.note else ()
    return Track(
        video=film.path,
        method=options.method,
        time_s=time_s,
        angle_deg=np.rad2deg(angles.angle_rad - angles.angle_rad[0]),
        sigma_deg=np.rad2deg(angles.sigma_rad),
        flags=angles.flags,
        pivot_px=(float(x), float(y)),
        template_px=subject.box,
        outline_px=plane.to_picture(subject.outline),
        plane=plane,
        notes=(
            *(angles.notes or (subject.view.note,)),
            *shutter_notes,
            *film.notes(measured.stamps_s),
        ),
        shared_deg=np.rad2deg(angles.shared_rad),
        shutters=instrument.shutters,
    )


def find_subject(film: Film, options: TrackOptions) -> Subject:
    """The moving part, its pivot and its plane from the calm frames of a stabilised video."""
    images, beside = film.images, options.beside
    if beside is None:
        view = view_of(images, options.camera)
    else:
        view = same_view(beside, options.camera)
        images = images if options.template is not None else without(images, beside)
    rectified = rectifier(view.plane, images[0].shape)
    pivot = options.pivot
    if pivot is not None:
        x, y = view.plane.of_picture(np.array([pivot]))[0]
        pivot = float(x), float(y)
    flat = [rectified(image) for image in images]
    surface = acquire(film.path, flat, pivot, options.template)
    surface = replace(surface, grid=replace(surface.grid, plane=view.plane))
    estimator = SurfaceEstimator.of(surface, images[0].shape)
    start_rad = estimator.search(images[0], 0.0, np.pi)
    home = estimator.fit_near(images[0], start_rad, STILL)
    home_rad = home.angle_rad if home is not None else 0.0
    outline = turned(surface.outline_px, surface.pivot_px, home_rad)
    box = options.template or choose_box(outline, surface.pivot_px, flat[0])
    return Subject(view, rectified, flat[0], surface, estimator, home_rad, outline, box)


def measure(
    film: Film, subject: Subject, instrument: Instrument, progress: FrameProgress | None = None
) -> Measured:
    """Measure every frame; InputError where the part is found in none of them."""
    radius_px = subject.surface.grid.largest_px
    rows = []
    for seen in follow(
        instrument.estimator,
        film.frames(),
        instrument.home_rad,
        instrument.shutters,
        radius_px,
        film.predicted,
    ):
        frame = seen.frame
        rows.append((frame.time_s, frame.sigma_px, seen.fit, seen.exposure, seen.repeated))
        if progress is not None:
            progress(frame.index + 1, film.header.count)
    stamps, alignment, fits, exposures, repeated = (list(c) for c in zip(*rows, strict=True))
    measured = Measured(stamps, alignment, fits, exposures, repeated, radius_px)
    if all(fit is None for fit in measured.fits):
        raise InputError(
            f"{film.path}: the surface was found in none of {len(rows)} frames; expected it in "
            "most of them, point at it with --pivot X,Y and --template X,Y,W,H."
        )
    return measured
