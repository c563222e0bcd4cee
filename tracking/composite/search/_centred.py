"""Parts learnt about pivots, and the pivots corrected from where the parts are seen shifted."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite._hint import Hint, references_for
from servosight.tracking.composite.model import CompositeModel, pivot_step
from servosight.tracking.composite.parts import Change, Reference, TurningPart, learnt
from servosight.tracking.core import threaded

FAR = 0.62  # of the longer side: how far a part reaches
_ROUNDS, _SETTLED_PX = 5, 0.2
_MARGIN = 1.25  # of a part's radius, in which it is learnt anew
_SOFT_PX = 1.5


def parts_about(
    pictures: Single, change: Change, pivots: list[Array], references: list[Reference]
) -> list[TurningPart]:
    """The parts learnt about each of the pivots about which something holds."""
    reach = FAR * max(pictures.shape[1:])
    places = [(float(x), float(y)) for x, y in pivots]
    parts = threaded(lambda place: learnt(pictures, change, place, reach, references), places)
    return [part for part in parts if part is not None]


def softly_corrected(pictures: Single, pivots: list[Array], hint: Hint | None) -> list[Array]:
    """Pivots (2,) corrected in blurred pictures: turned about one that is a pixel off, a needle of
    one pixel lies beside itself, and nothing holds."""
    soft = np.stack([_blurred(picture) for picture in pictures])
    change = Change.of(soft)
    if not change.moved.any():
        return []
    seen = hint and replace(hint, picture=_blurred(hint.picture))
    references = references_for(soft, change, seen)
    parts = parts_about(soft, change, pivots, references)
    better = threaded(lambda part: converged(soft, change, part, references), parts)
    return [np.array(part.view.pivot_px) for part in better]


def _blurred(picture: Single) -> Single:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), _SOFT_PX), np.float32)


def converged(
    pictures: Single, change: Change, part: TurningPart, references: list[Reference]
) -> TurningPart:
    """The part about the pivot to which corrections lead."""
    for _ in range(_ROUNDS):
        better = _recentred(pictures, change, part, references)
        moved_px = float(np.hypot(*np.subtract(better.view.pivot_px, part.view.pivot_px)))
        part = better
        if moved_px < _SETTLED_PX:
            break
    return part


def _recentred(
    pictures: Single, change: Change, part: TurningPart, references: list[Reference]
) -> TurningPart:
    """The part about a better pivot, from where it is seen shifted at its angles."""
    view = part.view
    model = CompositeModel.of(
        pictures, part.angle_rad, view.pivot_px, part.cover, view, change.usual
    )
    fits = model.fits(pictures, part.angle_rad, shifted=True)
    good = [fit for fit in fits if fit is not None and fit.explained > 0.3 and fit.kept > 0.4]
    if len(good) < 6:
        return part
    angles = np.array([fit.angle_rad for fit in good])
    shifts = np.array([fit.shift_px for fit in good])
    spread = np.median(np.abs(shifts - np.median(shifts, axis=0))) + 0.1
    near = (np.abs(shifts - np.median(shifts, axis=0)) < 5.0 * spread).all(1)
    known = np.stack([fit.covariance[1:, 1:] for fit in good])
    step, _ = pivot_step(angles[near], shifts[near], known[near])
    step *= min(1.0, 8.0 / max(float(np.hypot(*step)), 1e-9))
    x, y = np.array(view.pivot_px) + step
    rows = np.flatnonzero(part.cover.any(1))
    reach = min(float(view.rows), _MARGIN * float(rows[-1]) + 8.0) * view.step_px
    fresh = learnt(pictures, change, (float(x), float(y)), reach, references)
    return fresh if fresh is not None and fresh.explained > 0.97 * part.explained else part
