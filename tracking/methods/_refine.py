"""Method ``refine``: Gauss-Newton on the angle, over all pixels that depend on it."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from servosight.models.core import FrameProgress, Image
from servosight.tracking.acquisition import POINT, check_hints
from servosight.tracking.appearance.layers import LayerEstimator, layer_estimator
from servosight.tracking.calibration.shutter import find_shutter, first_pass
from servosight.tracking.composite import TRUST, swept_deg, uncertain
from servosight.tracking.core import Shutters, Track, TrackOptions, TrackRefused
from servosight.tracking.methods._compared import (
    alike,
    beside,
    change_of,
    changes_beside,
    surest,
)
from servosight.tracking.methods._composite import composite, composite_about
from servosight.tracking.methods._frames import (
    MovingPart,
    TrackedPart,
    TrackingSetup,
    tracked_part,
)
from servosight.tracking.methods._time_error import late_rms_deg
from servosight.tracking.methods._total_sigma import with_total_sigma
from servosight.tracking.video import Film

_LEAST_FOUND = 0.8  # of the frames: in others blur may have hidden the part's texture
_PIECE_DEG = 0.05  # sigma of what ``composite`` is not surer than
_MORE = 2.0  # times the change of the pictures, of another part that is measured in its place
_LITTLE = 0.25  # of the change of a part: what changes elsewhere is then no part that is meant


def refine(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """Fit the angle to all pixels of the moving part, its outline and shadow included.

    Exposure and readout are found from the video where they are not given. Where no track is found
    so that the frames confirm, or one whose angles or times are too uncertain or that loses the
    part in many frames, ``composite`` is tried; and where a piece of the part that is pointed at
    leaves its angles uncertain.
    """
    if options.pick > 1:  # the candidates are those of ``composite``
        check_hints(film.path, options, film.images[0].shape)
        return composite(film, options, progress)
    try:
        part = tracked_part(film, options, progress, prepare)
    except TrackRefused as refused:
        if not _may_be_composite(options):
            raise
        try:
            return composite(film, options, progress)
        except TrackRefused as again:
            raise _farther(refused, again, options.pointed) from again
    track = part.track
    why = uncertain(track.angle_deg[track.found], track.sigma_deg[track.found])
    if why is not None and _may_be_composite(options):
        return _surer(part, why, film, options, progress)
    measured = with_total_sigma(part.along_axis())
    enough_deg = TRUST.most_deg(swept_deg(measured.angle_deg[measured.found]))
    late = late_rms_deg(measured) > enough_deg
    lost = float(np.mean(measured.found)) < _LEAST_FOUND
    if _may_be_composite(options) and (late or lost or _of_a_piece(part, options)):
        return _surer_of_both(measured, film, options, progress)
    return measured


def _surer(
    part: TrackedPart, why: str, film: Film, options: TrackOptions,
    progress: FrameProgress | None,
) -> Track:  # fmt: skip
    """The track of ``composite`` in place of an uncertain one; that one, with a note, where the
    user points at the part and ``composite`` does not find it. ``why`` says how uncertain it is."""
    try:
        return composite(film, options, progress)
    except TrackRefused as again:
        if options.pointed:
            return with_total_sigma(part.along_axis())
        x, y = part.track.pivot_px
        sentence = (
            f"{film.path}: the part about {x:.0f},{y:.0f} {why}, film it larger, sharper or with "
            f"more light, {POINT}."
        )
        raise TrackRefused(sentence, again.draw, measured=True) from again


def _farther(refused: TrackRefused, again: TrackRefused, pointed: bool) -> TrackRefused:
    """What to say where ``refine`` and then ``composite`` refused: the sentence that names a part,
    as where to point is what helps; that of ``composite`` if both do, which its picture shows, or
    where the user pointed at a place, of which it speaks."""
    if again.found or (pointed and not refused.found):
        return again
    return refused if refused.found else TrackRefused(str(refused), again.draw)


def _of_a_piece(part: TrackedPart, options: TrackOptions) -> bool:
    """Whether the user points at a piece of the part, from which the surface was learnt, and that
    tells the angle so roughly that the whole part may tell it better."""
    piece = options.tip is not None or options.template is not None
    return piece and float(np.median(part.track.sigma_deg[part.track.found])) > _PIECE_DEG


def _surer_of_both(
    measured: Track, film: Film, options: TrackOptions, progress: FrameProgress | None
) -> Track:
    """The track of ``composite`` in place of another one of the part, if it finds that in far more
    frames, or its angles are the surer ones in most: the edges of a plain part show its blur, its
    interior does not.

    Where they are not, but tell exposure and readout better, it is measured again with these.
    Of two parts beside each other that turn each in its own way, that one which changes far more of
    the pictures.
    """
    try:
        other = _compared_to(measured, film, options, progress)
    except TrackRefused:
        return measured
    if not alike(measured, other):
        if options.pointed or not beside(measured, other):
            return measured
        return _of_two(measured, other, film.stabilised.images)
    if _tells_times(other, measured):
        timed = film.exposed(other.shutters)
        with suppress(TrackRefused):  # as it was measured first then
            measured = with_total_sigma(
                tracked_part(timed, options, progress, prepare).along_axis()
            )
    return surest(measured, other)


def _compared_to(
    measured: Track, film: Film, options: TrackOptions, progress: FrameProgress | None
) -> Track:
    """The track of ``composite`` of the part that changes most; of the same part, where little
    changes elsewhere: that takes a third of the time or less."""
    if not options.pointed and not changes_beside(measured, film.stabilised.images, _LITTLE):
        with suppress(TrackRefused):
            return composite_about(film, options, measured.pivot_px, progress)
    return composite(film, options, progress)


def _of_two(measured: Track, other: Track, images: Sequence[Image]) -> Track:
    """``measured``, or ``other`` where far more of the pictures changes; the one that is not taken
    is named."""
    taken, left = measured, other
    if change_of(other, images) > _MORE * change_of(measured, images):
        taken, left = other, measured
    x, y = left.pivot_px
    note = (
        f"the part about {x:.0f},{y:.0f} px may be meant as well: it turns in another way; "
        f"--pivot {x:.0f},{y:.0f} takes it"
    )
    return replace(taken, notes=(*taken.notes, note))


def _tells_times(track: Track, other: Track) -> bool:
    """Whether exposure and readout of a track make its times surer than those of another one."""
    if track.shutters is None or other.shutters is None:
        return False
    return track.shutters.middle_doubt_s < other.shutters.middle_doubt_s


def _may_be_composite(options: TrackOptions) -> bool:
    """Whether what is given leaves the choice of the model open."""
    return options.camera is None and not options.textured


def prepare(film: Film, part: MovingPart) -> TrackingSetup:
    """The estimator over layers, or over the interior where the layers are no better."""
    interior = part.estimator
    look = partial(first_pass, film, interior)
    shutters = film.shutters
    if shutters is None:
        still = look(Shutters(np.zeros(1), 0.0))
        shutters = find_shutter(interior, still, part.rectified, film.sideways)
    estimator = layer_estimator(look(shutters), interior, film.run_frames)
    pivot = part.surface.pivot_px
    if isinstance(estimator, LayerEstimator):  # the layers refine the pivot as they are learnt
        pivot = estimator.layers.grid.pivot_px
    return TrackingSetup(estimator, part.initial_rad, pivot, shutters)
