"""Two frames beside each other: by which angle does what changes between them turn?

Neither the part's learnt picture nor its shape nor the background takes part: what differs in one
frame is turned until it lies on the other, both places within what differs. Angles that are too
small, because some of the part was taken for background, agree with their own model and not with
this.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import median_of
from servosight.tracking.verification._turning import PolarView

_PAIRS = 24
_SIGMAS, _LEAST_STEP = 4.0, 5.0
_LEAST_CELLS = 30
_OTHER = 0.5  # times the turn: what is nearer is an angle that is too large or too small
_NEARLY = 0.6


def pairs_apart(angle_rad: Array) -> Array:
    """Frames (pairs, 2) by number, from the lower and the upper half of the angles (n,)."""
    order = np.argsort(angle_rad)
    half = len(order) // 2
    count = min(_PAIRS, half)
    steps = (np.arange(count) * half) // max(count, 1)
    return np.stack([order[steps], order[half + steps]], 1)


def turn_between(
    view: PolarView, first: Single, second: Single, swept: Mask, step: float
) -> tuple[Array, Array] | None:
    """By how much a turn of what changes from the first to the second frame explains the second
    one, and turned back the first one, and the angles [rad], (columns,) each; None where hardly
    anything changes.

    Frames (rows, columns) and ``swept``, where the part passes, on the raster; ``step`` is the
    smallest change.
    """
    differs = cv2.blur((np.abs(first - second) > step).astype(np.float32), (3, 3)) > 0.5
    template = differs & swept
    if template.sum() < _LEAST_CELLS:
        return None
    # Onto what differs alone: the background that the part is about to cover is turned with it,
    # and before clutter that would count more than a part that hardly stands out. Both ways, since
    # else background turned onto what the part uncovers may explain more than the part itself.
    cover = template.astype(np.float32)
    there, back = (np.where(template, one, np.float32(np.nan)) for one in (second, first))
    angles = view.angles()
    backwards = (2 * (view.columns // 2) - np.arange(view.columns)) % view.columns
    gain = view.gains(there, first, first, cover)
    return gain + view.gains(back, second, second, cover)[backwards], angles


def pair_agreement(
    view: PolarView, frames: Single, angle_rad: Array, swept: Mask,
    claimed: Callable[[float], Single], near_rad: float, as_good: float,
) -> float:  # fmt: skip
    """Share of pairs of frames (n, height, width) whose turn is that of their angles (n,).

    ``claimed`` is the frame on the raster that an angle [rad] is said to show, ``near_rad`` the
    tolerance, ``as_good`` the share of the best gain that the angles must reach. A pair tells
    nothing where another turn explains it better, which by what is claimed would explain nearly as
    much: of a plain plate that turns by less than its own width, what differs is one edge of it in
    the first frame and the other edge in the second one, and these are a width apart. 1 where no
    pair tells anything.
    """
    away = (frames - median_of(frames))[:, ::2, ::2]
    step = _SIGMAS * 1.4826 * float(np.median(np.abs(away))) + _LEAST_STEP
    reached = np.nan_to_num(view.of(swept.astype(np.float32), nearest=True)) > 0
    agreed = []
    for one, other in pairs_apart(angle_rad):
        seen = turn_between(view, view.of(frames[one]), view.of(frames[other]), reached, step)
        if seen is None:
            continue
        true_rad = float(angle_rad[other] - angle_rad[one])
        best_rad = float(seen[1][int(np.argmax(seen[0]))])
        best, here = (_largest_near(*seen, rad, near_rad) for rad in (best_rad, true_rad))
        same = best > 0.0 and here >= as_good * best
        if not same and _apart(best_rad, true_rad) > _OTHER * abs(true_rad):
            said = turn_between(
                view, claimed(angle_rad[one]), claimed(angle_rad[other]), reached, step
            )
            if said is not None:
                best, here = (_largest_near(*said, rad, near_rad) for rad in (best_rad, true_rad))
                if best >= _NEARLY * here:
                    continue
        agreed.append(same)
    return float(np.mean(agreed)) if agreed else 1.0


def _largest_near(gain: Array, angles: Array, angle_rad: float, near_rad: float) -> float:
    """The largest gain (columns,) as near an angle [rad] as that."""
    return float(gain[_apart(angles, angle_rad) <= near_rad].max())


def _apart(first_rad: Any, second_rad: float) -> Any:
    """By how much angles [rad] differ."""
    return np.abs(np.angle(np.exp(1j * (first_rad - second_rad))))
