"""The angles about the pivot, and in the plane, that all frames of a video tell together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array
from servosight.tracking.calibration._view import View
from servosight.tracking.fit import PIVOT, PLANE, Fit, Lean, hinge, mended

_SURE = 5.0  # sigma, from which a plane that no feature told is taken for seen


@dataclass(frozen=True)
class Mended:
    """Fits about the true hinge; by how much the pivot is another [px]; what one sigma of what all
    frames share leaves in the angles [rad], (frames, errors); what there is to say of it."""

    fits: list[Fit | None]
    moved_px: Array
    shared_rad: Array
    notes: tuple[str, ...] = ()


def about_hinge(fits: list[Fit | None], view: View, pivot_held: bool) -> Mended:
    """What is given stays as it is: the pivot where it is held, the plane of a calibration.

    A plane that the swing told is told better here; one that it did not tell is taken for seen
    where what it mends outweighs its doubt.
    """
    known = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    of_view = np.nan_to_num(view.shared_rad(known - known[np.isfinite(known)][0]))
    first = PIVOT.stop if pivot_held else PIVOT.start
    plain = _told(fits, slice(first, PIVOT.stop))
    kept = replace(plain, shared_rad=np.hstack([plain.shared_rad, of_view]))
    if view.calibrated:
        return kept
    whole = _told(fits, slice(first, PLANE.stop))
    doubt = _size(whole.shared_rad)
    if view.found:
        return whole if 0.0 < doubt < _size(of_view) else kept
    mends = [
        a.angle_rad - b.angle_rad for a, b in zip(whole.fits, plain.fits, strict=True) if a and b
    ]
    if not 0.0 < _SURE * doubt < np.std(mends):
        return kept
    note = (
        "all frames together tell that the camera is a little off the hinge's axis: corrected, "
        f"without that angles would be wrong by {np.rad2deg(np.std(mends)):.2g} deg rms"
    )
    return replace(whole, notes=(note,))


def _told(fits: list[Fit | None], free: slice) -> Mended:
    """With the ``free`` sways as all frames tell them; the fits as they are where too few do."""
    leaning: dict[int, tuple[Fit, Lean]] = {
        n: (fit, fit.lean) for n, fit in enumerate(fits) if fit and fit.lean
    }
    angle = np.array([fit.angle_rad for fit, _ in leaning.values()])
    leans: Sequence[Lean] = [lean for _, lean in leaning.values()]
    found = hinge(angle, leans, free) if free.start < free.stop else None
    if found is None:
        return Mended(fits, np.zeros(2), np.zeros((len(fits), 0)))
    about, own = mended(angle, leans, found, free)
    shared = np.zeros((len(fits), own.shape[1]))
    shared[list(leaning)] = own
    told = list(fits)
    for (place, (fit, _)), mean in zip(leaning.items(), about.tolist(), strict=True):
        told[place] = replace(fit, angle_rad=mean)
    moved = found.sway_px[: PIVOT.stop] if free.start == PIVOT.start else np.zeros(2)
    return Mended(told, moved, shared)


def _size(shared_rad: Array) -> float:
    """Root mean square over frames of what all the errors make together."""
    return float(np.sqrt((shared_rad**2).sum(1).mean()))
