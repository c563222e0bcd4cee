"""The pipeline shared by methods that measure frame after frame.

Find the moving part; prepare the method's own estimator; track the frames; evaluate all of them
together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array, FrameProgress, Image, InputError
from servosight.tracking.acquisition import (
    POINT,
    acquire,
    check_hints,
    pointed_box,
    same_view,
    without,
)
from servosight.tracking.appearance.surface import Surface, SurfaceEstimator
from servosight.tracking.calibration import CameraView, rectifier, view_of
from servosight.tracking.core import STILL, Box, Features, Shutters, Track, TrackOptions, turned
from servosight.tracking.fit import AngleEstimator, StartCheck, follow
from servosight.tracking.methods._along_axis import seen_along_axis
from servosight.tracking.methods._box import choose_box
from servosight.tracking.methods._verified import refused_with_picture, verify
from servosight.tracking.uncertainty import FrameMeasurements, evaluate
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import MOST_UNCLEAR, Film


@dataclass(frozen=True)
class MovingPart:
    """The moving part, found from the motion or from the user's options.

    ``view`` is the camera's view of its plane, ``rectified`` resamples pictures into that plane and
    ``first`` is the first one resampled. ``estimator`` measures it by its interior, ``initial_rad``
    is its angle in the first frame relative to the learnt ``surface``, ``outline`` (points, 2) its
    contour there in the plane, ``box`` the square on it that determines the angle best.
    """

    view: CameraView
    rectified: Callable[[Image], Image]
    first: Image
    surface: Surface
    estimator: SurfaceEstimator
    initial_rad: float
    outline: Array
    box: Box


@dataclass(frozen=True)
class TrackingSetup:
    """The estimator of each frame, from ``initial_rad`` in the first one.

    ``pivot`` is x, y in the plane about which the part turns, ``shutters`` the exposure of rows.
    """

    estimator: AngleEstimator
    initial_rad: float
    pivot: tuple[float, float]
    shutters: Shutters


Prepare = Callable[[Film, MovingPart], TrackingSetup]


@dataclass(frozen=True)
class TrackedPart:
    """A track that the frames confirm, seen in the plane in which it was measured.

    ``outline`` (points, 2) in the first frame and ``pivot`` (2,) lie in that plane, as the pictures
    of the ``sample`` do. ``tilt_known`` says that it is calibrated, or that pictures without a
    predicting codec determine it; ``view_note`` is what was said of it before the frames were
    measured.
    """

    track: Track
    sample: FrameSample
    outline: Array
    pivot: Array
    tilt_known: bool
    view_note: str

    def along_axis(self) -> Track:
        """With what the tilt of the camera may do to the angles, and corrected for one found."""
        if self.tilt_known:
            return self.track
        return seen_along_axis(self.track, self.sample, self.outline, self.pivot, self.view_note)


def track_frames(
    film: Film, options: TrackOptions, progress: FrameProgress | None, prepare: Prepare
) -> Track:
    """Track by an estimator that ``prepare`` makes for the moving part; InputError if not found."""
    return tracked_part(film, options, progress, prepare).along_axis()


def tracked_part(
    film: Film, options: TrackOptions, progress: FrameProgress | None, prepare: Prepare
) -> TrackedPart:
    """As ``track_frames``, before the camera's tilt is looked for."""
    check_hints(film.path, options, film.images[0].shape)
    film = film.stabilised
    options = film.in_first(options)
    with refused_with_picture(film):
        _check_camera(film)
        part = find_moving_part(film, options)
        setup = prepare(film, part)
        sample = FrameSample.of_video(part.rectified, film.header.count)
        measured = measure(film, part, setup, sample, progress)
    time_s = film.times(measured.stamps_s, setup.shutters.middle_s)
    angles = evaluate(
        measured,
        time_s,
        part.view,
        setup.shutters,
        learnt=len(film.calm),
        correlated=film.predicted or film.stabiliser is not None,
    )
    plane = part.view.plane
    pivot = np.array(setup.pivot) + angles.pivot_shift_px
    x, y = plane.to_picture(pivot[None])[0]
    shutter_notes = (setup.shutters.note,) if setup.shutters.note else ()
    track = Track(
        video=film.path,
        method=options.method,
        time_s=time_s,
        angle_deg=np.rad2deg(angles.angle_rad - angles.angle_rad[0]),
        sigma_deg=np.rad2deg(angles.sigma_rad),
        flags=angles.flags,
        pivot_px=(float(x), float(y)),
        template_px=part.box,
        outline_px=plane.to_picture(part.outline),
        plane=plane,
        notes=(
            *(angles.notes or (part.view.note,)),
            *shutter_notes,
            *film.notes(measured.stamps_s, measured.missing),
        ),
        lost=film.lost(measured.stamps_s, measured.missing),
        shared_deg=np.rad2deg(angles.shared_rad),
        shutters=setup.shutters,
        tilt=angles.tilt or part.view.tilt,
    )
    verify(film, options, track, pivot, [part.outline], sample)
    known = part.view.calibrated or not film.predicted
    return TrackedPart(track, sample, part.outline, pivot, known, part.view.note)


def _check_camera(film: Film) -> None:
    """``InputError`` where the camera moves and it is not known how: its motion would be measured
    as the part's."""
    if film.camera.unclear > MOST_UNCLEAR:
        raise InputError(
            f"{film.path}: the camera moves, and in {film.camera.unclear:.0%} of the pictures "
            "looked at the features of the background do not show by how much; expected a "
            "background with texture, sharp and in good light, or a camera that is mounted."
        )


def find_moving_part(film: Film, options: TrackOptions) -> MovingPart:
    """The moving part, its pivot and its plane, from slow frames of a stabilised video."""
    images, beside = film.images, options.beside
    shape = images[0].shape
    box = pointed_box(options, shape)
    if options.at_s is not None and box is not None:
        images = [film.frame_at(options.at_s).image, *images]
    if beside is not None and box is None:
        images = without(images, beside)
    features = Features.of_change(images)
    if beside is None:
        view = view_of(images, options.camera, film.predicted, features)
    else:
        view = same_view(beside, options.camera)
    rectified = rectifier(view.plane, shape)
    pivot = options.pivot
    if pivot is not None:
        x, y = view.plane.of_picture(np.array([pivot]))[0]
        pivot = float(x), float(y)
    flat = [rectified(image) for image in images]
    if not view.plane.is_picture:
        features = Features.of_change(flat)
    surface = acquire(film.path, flat, pivot, box, features)
    surface = replace(surface, grid=replace(surface.grid, plane=view.plane))
    estimator = SurfaceEstimator.of(surface, shape)
    first = len(images) - len(film.images)  # after the frame pointed at
    start_rad = estimator.search(images[first], 0.0, np.pi)
    home = estimator.fit_near(images[first], start_rad, STILL)
    initial_rad = home.angle_rad if home is not None else 0.0
    outline = turned(surface.outline_px, surface.pivot_px, initial_rad)
    if options.template is None or options.at_s is not None:
        box = choose_box(outline, surface.pivot_px, flat[first])
    else:
        box = options.template
    return MovingPart(view, rectified, flat[first], surface, estimator, initial_rad, outline, box)


def measure(
    film: Film,
    part: MovingPart,
    setup: TrackingSetup,
    sample: FrameSample,
    progress: FrameProgress | None = None,
) -> FrameMeasurements:
    """Measure every frame; InputError where the part is found in none of them.

    ``sample`` keeps some of the frames.
    """
    radius_px = part.surface.grid.largest_px
    rows = []
    starts = StartCheck(setup.estimator, radius_px, film.header.count)
    followed = follow(
        setup.estimator,
        sample.watch(film.frames()),
        setup.initial_rad,
        setup.shutters,
        radius_px,
        film.predicted,
    )
    for seen in starts.watch(followed):
        frame = seen.frame
        rows.append(
            (
                frame.time_s,
                frame.sigma_px,
                seen.fit,
                seen.exposure,
                seen.repeated,
                frame.missing,
            )
        )
        if progress is not None:
            progress(frame.index + 1, film.header.count)
    stamps, alignment, fits, exposures, repeated, missing = (
        list(c) for c in zip(*rows, strict=True)
    )
    measured = FrameMeasurements(
        stamps, alignment, fits, exposures, repeated, radius_px, starts.sigma_rad, missing
    )
    if all(fit is None for fit in measured.fits):
        raise InputError(
            f"{film.path}: the surface was found in none of {len(rows)} frames; expected it in "
            f"most of them, {POINT}."
        )
    return measured
