"""The sampled pictures fitted by a part that is learnt, and the part learnt again from that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.composite.model import CompositeModel, pivot_step

_UNKNOWN_PX = 3.0
# The pivot moves by so much at most, and by that share of the part's reach: a long pointer that
# turns by 5 deg is found with its pivot a third of its length off.
_LARGEST_PX, _LARGEST_SHARE = 6.0, 0.25


@dataclass(frozen=True)
class Refit:
    """Better angles [rad] of pictures (n,), which of them show the part, by how much the pivot is
    off (2,) [px], and the sigma of that."""

    angle_rad: Array
    good: Mask
    step_px: Array
    doubt_px: float


def refitted(model: CompositeModel, pictures: Single, angles: Array) -> Refit:
    """The pictures fitted by turn and shift, from angles (n,)."""
    fits = model.fits(pictures, angles, shifted=True)
    good = np.array([fit is not None and fit.shown for fit in fits])
    refined, shifts = angles.copy(), np.zeros((len(fits), 2))
    for number, fit in enumerate(fits):
        if fit is not None and good[number]:
            refined[number], shifts[number] = fit.angle_rad, fit.shift_px
    if good.sum() < 6:
        return Refit(angles, np.ones(len(fits), bool), np.zeros(2), _UNKNOWN_PX)
    middle = np.median(shifts[good], axis=0)
    spread = 5.0 * float(np.median(np.abs(shifts[good] - middle))) + 0.3
    near = good & (np.abs(shifts - middle) < spread).all(1)
    known = np.stack([np.zeros((2, 2)) if fit is None else fit.covariance[1:, 1:] for fit in fits])
    step, doubt = pivot_step(refined[near], shifts[near], known[near])
    # The angle was fitted beside the shift: about the better pivot it is fitted alone.
    largest_px = max(_LARGEST_PX, _LARGEST_SHARE * float(model.radius_px.max()))
    step *= min(1.0, largest_px / max(float(np.hypot(*step)), 1e-9))
    return Refit(refined, good, step, float(np.sqrt(np.trace(doubt))))
