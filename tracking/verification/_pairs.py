"""Two frames beside each other: by which angle does what changes between them turn?

Neither the part's learnt picture nor its shape nor the background takes part: what differs in one
frame is turned until it lies on the other. Angles that are too small, because some of the part was
taken for background, agree with their own model and not with this.
"""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.verification._turning import PolarView

_PAIRS = 16
_SIGMAS, _LEAST_STEP = 4.0, 5.0
_LEAST_CELLS = 30


def pairs_apart(angle_rad: Array) -> Array:
    """Frames (pairs, 2) by number, from the lower and the upper half of the angles (n,)."""
    order = np.argsort(angle_rad)
    half = len(order) // 2
    count = min(_PAIRS, half)
    steps = (np.arange(count) * half) // max(count, 1)
    low, high = order[steps], order[half + steps]
    return np.concatenate([np.stack([low, high], 1), np.stack([high, low], 1)])


def turn_between(
    view: PolarView, first: Single, second: Single, swept: Mask, step: float
) -> tuple[Array, Array] | None:
    """By how much a turn of what changes from the first to the second frame explains the second
    one, and the angles [rad], (columns,) each; None where hardly anything changes.

    Frames (rows, columns) and ``swept``, where the part passes, on the raster; ``step`` is the
    smallest change.
    """
    differs = cv2.blur((np.abs(first - second) > step).astype(np.float32), (3, 3)) > 0.5
    template = (differs & swept).astype(np.float32)
    if template.sum() < _LEAST_CELLS:
        return None
    return view.gains(second, first, first, template), view.angles()


def pair_agreement(
    view: PolarView, frames: Single, angle_rad: Array, swept: Mask, near_rad: float, as_good: float
) -> float:
    """Share of pairs of frames (n, height, width) whose turn is that of their angles (n,).

    ``near_rad`` is the tolerance, ``as_good`` the share of the best gain that the angles must
    reach. 1 where no pair changes enough to tell.
    """
    away = (frames - np.median(frames, axis=0))[:, ::2, ::2]
    step = _SIGMAS * 1.4826 * float(np.median(np.abs(away))) + _LEAST_STEP
    reached = np.nan_to_num(view.of(swept.astype(np.float32), nearest=True)) > 0
    agreed = []
    for one, other in pairs_apart(angle_rad):
        turn = turn_between(view, view.of(frames[one]), view.of(frames[other]), reached, step)
        if turn is None:
            continue
        gain, angles = turn
        true = angle_rad[other] - angle_rad[one]
        near = np.abs(np.angle(np.exp(1j * (angles - true)))) <= near_rad
        best = float(gain.max())
        agreed.append(best > 0.0 and float(gain[near].max()) >= as_good * best)
    return float(np.mean(agreed)) if agreed else 1.0
