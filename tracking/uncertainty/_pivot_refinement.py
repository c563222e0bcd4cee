"""Pivot and plane refined by all frames of a video together, and the angles about them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array
from servosight.tracking.calibration import CameraView
from servosight.tracking.core import Tilt
from servosight.tracking.fit import (
    PIVOT,
    PLANE,
    AngleFit,
    PoseSensitivity,
    corrected_angles,
    rotation_axis,
)

# Sigmas from which a tilt that no feature showed is taken as real: of the frames' noise alone, and
# with that of the learnt picture.
_SURE, _SURE_IN_ALL = 5.0, 3.0


@dataclass(frozen=True)
class PivotRefinement:
    """Fits about the refined pivot.

    ``shift_px`` (2,) is the refined pivot minus the assumed one [px]. ``shared_rad`` (frames,
    errors) is the change of the angles [rad] with one sigma of each error that all frames share.
    ``tilt`` is the camera's where all frames together show what the swing did not.
    """

    fits: list[AngleFit | None]
    shift_px: Array
    shared_rad: Array
    notes: tuple[str, ...] = ()
    tilt: Tilt | None = None


def refine_pivot(fits: list[AngleFit | None], view: CameraView, learnt: int) -> PivotRefinement:
    """Refine the pivot, and the plane unless it was calibrated.

    ``learnt`` is the number of frames from which the moving part's picture was learnt. Its noise is
    in the residuals of all frames, and does not average out over them: a mean over n frames less
    one over ``learnt`` frames has a variance 1 + n / learnt times that of the first alone, and by
    that the shared errors are wider than the frames alone say.

    A plane found from the swing is replaced where this one is more certain. Where the swing showed
    no tilt, one is taken as real if its correction is well above its sigma, also where that is
    widened: the noise of the learnt picture looks like a tilt, the same in all frames.
    """
    angle = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    of_view = np.nan_to_num(view.shared_rad(angle - angle[np.isfinite(angle)][0]))
    by_pivot = _refined(fits, PIVOT)
    wider = np.sqrt(1.0 + sum(fit is not None for fit in fits) / learnt)
    kept = replace(by_pivot, shared_rad=np.hstack([wider * by_pivot.shared_rad, of_view]))
    if view.calibrated:
        return kept
    by_both = _refined(fits, slice(PIVOT.start, PLANE.stop))
    sigma = _rms(by_both.shared_rad)
    by_both = replace(by_both, shared_rad=wider * by_both.shared_rad)
    if view.found:
        return by_both if 0.0 < sigma < _rms(of_view) else kept
    pairs = zip(by_both.fits, by_pivot.fits, strict=True)
    corrections = [a.angle_rad - b.angle_rad for a, b in pairs if a and b]
    if not 0.0 < max(_SURE, _SURE_IN_ALL * wider) * sigma < np.std(corrections):
        return kept
    changed_deg = float(np.rad2deg(np.std(corrections)))
    note = (
        "all frames together show that the camera is slightly off the axis of rotation: corrected, "
        f"without that angles would be wrong by {changed_deg:.2g} deg rms"
    )
    tilt = Tilt(corrected_deg=changed_deg, sigma_deg=float(np.rad2deg(wider * sigma)))
    return replace(by_both, notes=(note,), tilt=tilt)


def _refined(fits: list[AngleFit | None], free: slice) -> PivotRefinement:
    """With the ``free`` pose errors estimated; the fits as they are where too few frames show
    them."""
    usable: dict[int, tuple[AngleFit, PoseSensitivity]] = {
        n: (fit, fit.sensitivity) for n, fit in enumerate(fits) if fit and fit.sensitivity
    }
    angle = np.array([fit.angle_rad for fit, _ in usable.values()])
    sensitivities = [one for _, one in usable.values()]
    axis = rotation_axis(angle, sensitivities, free) if free.start < free.stop else None
    if axis is None:
        return PivotRefinement(fits, np.zeros(2), np.zeros((len(fits), 0)))
    corrected, own = corrected_angles(angle, sensitivities, axis, free)
    shared = np.zeros((len(fits), own.shape[1]))
    shared[list(usable)] = own
    refined = list(fits)
    for (place, (fit, _)), about in zip(usable.items(), corrected.tolist(), strict=True):
        refined[place] = replace(fit, angle_rad=about)
    shift = axis.error_px[: PIVOT.stop] if free.start == PIVOT.start else np.zeros(2)
    return PivotRefinement(refined, shift, shared)


def _rms(shared_rad: Array) -> float:
    """Root mean square over frames of all errors together."""
    return float(np.sqrt((shared_rad**2).sum(1).mean()))
