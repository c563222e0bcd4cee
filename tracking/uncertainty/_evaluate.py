"""From the fits of all frames to angles and their sigma."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.tracking.calibration import CameraView
from servosight.tracking.core import Exposure, Flag, Shutters, Tilt, principal
from servosight.tracking.fit import AngleFit
from servosight.tracking.uncertainty._flicker import light_centre
from servosight.tracking.uncertainty._lasting import with_scatter
from servosight.tracking.uncertainty._middle_row import at_middle_row
from servosight.tracking.uncertainty._pivot_refinement import refine_pivot
from servosight.tracking.uncertainty._sigma import (
    columns,
    flags_of,
    gaps,
    shown_share,
    speeds,
    uneven,
)

_LOST_DEG = 1.0  # sigma where a frame cannot be aligned with the first one
_ARM = 0.6  # of the largest radius: the mean distance of what determines the angle


@dataclass(frozen=True)
class FrameMeasurements:
    """The measurements of the single frames; one entry a frame.

    Presentation times [s], sigma of the frame's alignment with the first one [px], the fit (None
    where the part was not found), the motion while exposed, whether the picture is the one before;
    the radius of the part's tip [px]; the sigma of the angles by the start of their fits [rad]; and
    how many pictures before each frame could not be used, none where empty.
    """

    stamps_s: Sequence[float]
    alignment_px: Sequence[float]
    fits: list[AngleFit | None]
    exposures: Sequence[Exposure]
    repeated: Sequence[bool]
    radius_px: float
    by_start_rad: float = 0.0
    missing: Sequence[int] = ()


@dataclass(frozen=True)
class EvaluatedAngles:
    """Angle and sigma [rad] (frames,) and ``Flag`` bits (frames,).

    ``shared_rad`` (frames, errors) is the change of the angles with one sigma of each error that
    all frames share; ``sigma_rad`` includes it. ``pivot_shift_px`` (2,) corrects the assumed pivot.
    """

    angle_rad: Array
    sigma_rad: Array
    flags: NDArray[np.uint8]
    shared_rad: Array
    pivot_shift_px: Array
    notes: tuple[str, ...]
    tilt: Tilt | None


def evaluate(
    measured: FrameMeasurements,
    time_s: Array,
    view: CameraView,
    shutters: Shutters,
    *,
    learnt: int,
    correlated: bool,
) -> EvaluatedAngles:
    """Angles at mid-exposure of the middle row, ``time_s`` (frames,), with their sigma.

    ``learnt`` is the number of frames from which the part's picture was learnt.
    ``correlated`` adds the scatter from frame to frame, and what lasts for some of them,
    where the pixels' own errors do not account for it: a predicting codec, a moving camera.
    """
    flags = np.array([flags_of(fit) for fit in measured.fits], np.uint8)
    flags |= np.where(gaps(time_s, measured.missing), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    refined = refine_pivot(measured.fits, view, learnt)
    fits = refined.fits
    if shutters.readout_s != 0.0:
        fits, timing = at_middle_row(time_s, fits, measured.exposures, shutters.readout_s)
        # Under a rolling shutter there are errors that last for many frames and cause no scatter.
        angle, sigma, flags = columns(fits, flags, measured.repeated, 1.0)
    else:
        angle, sigma, flags = columns(fits, flags, measured.repeated, shown_share(fits))
        angle, timing = _at_light_centre(angle, time_s, fits, shutters)
    of_readout = _by_readout(angle, time_s, fits, shutters.readout_doubt_s)
    shared = principal(np.hstack([refined.shared_rad, of_readout]))
    if correlated:
        sigma = with_scatter(sigma, angle)
    sigma = np.sqrt(
        sigma**2
        + timing**2
        + uneven(angle, time_s, shutters.exposures_s) ** 2
        + _by_alignment(measured) ** 2
        + measured.by_start_rad**2
        + (shared**2).sum(1)
    )
    return EvaluatedAngles(
        angle, sigma, flags, shared, refined.shift_px, refined.notes, refined.tilt
    )


def _at_light_centre(
    angle: Array, time_s: Array, fits: Sequence[AngleFit | None], shutters: Shutters
) -> tuple[Array, Array]:
    """Angles converted from the time of the mean light to mid-exposure, and the sigma [rad] that
    this adds; (frames,) each."""
    gain = np.array([fit.gain if fit else np.nan for fit in fits])
    late_s, late_sigma_s = light_centre(time_s, gain, float(np.median(shutters.exposures_s)))
    speed, speed_sigma = speeds(angle, time_s)
    return angle - speed * late_s, np.hypot(speed * late_sigma_s, speed_sigma * late_s)


def _by_readout(
    angle: Array, time_s: Array, fits: Sequence[AngleFit | None], sigma_s: float
) -> Array:
    """Change of the angles with one sigma of the readout time, less a common delay; (frames, 1).

    (frames, 0) where the readout is known.
    """
    if sigma_s == 0.0:
        return np.zeros((angle.size, 0))
    delay = np.array([fit.delay if fit else np.nan for fit in fits])
    apart = np.nan_to_num(delay - np.nanmean(delay))
    speed = np.gradient(angle, time_s)
    return np.asarray(speed * apart * sigma_s, np.float64)[:, None]


def _by_alignment(measured: FrameMeasurements) -> Array:
    """Sigma [rad] of frames that were aligned with the first one to some pixels; (frames,)."""
    turn = np.array(measured.alignment_px) / (_ARM * measured.radius_px)
    return np.minimum(turn, np.deg2rad(_LOST_DEG))
