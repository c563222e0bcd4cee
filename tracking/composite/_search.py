"""From sampled pictures of a camera at rest to the part that turns in them: coarse, then fine."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite._model import CompositeModel, pivot_step
from servosight.tracking.composite._part import Change, TurningPart, diverse, learnt, pivot_scores

_COARSE_PX, _MIDDLE_PX = 160, 240  # the longer side
_STEP_PX, _BLUR_PX = 6.0, 2.5
_FINE_PX = 2.0
_REACH, _FAR = 0.45, 0.62  # of the longer side: how far a part reaches, at first and at last
_MOVED_SHARE = 0.04  # of the pictures in which a place must change
_TRIED, _APART = 4, 0.06  # pivots, and their distance as a share of the longer side
_PICTURES, _FEWER = 20, 14
_ROUNDS = 3


@dataclass(frozen=True)
class FoundPart:
    """A part that turns: its pivot [px], its model and the angles of the pictures it was learnt
    from, in pixels of the given pictures. ``chosen`` are their numbers."""

    pivot_px: tuple[float, float]
    part: TurningPart
    chosen: list[int]

    @property
    def explained(self) -> float:
        """Mean share of a picture's change that the turning part explains."""
        return self.part.explained


def find_parts(pictures: Single, pivot_px: Array | None = None) -> list[FoundPart]:
    """The parts that turn, the one that explains most of the change first; pictures (n, height,
    width) of one camera position. With ``pivot_px`` (2,) only about that."""
    chosen = diverse(pictures, _PICTURES)
    middle, scale = _scaled(pictures[chosen], _MIDDLE_PX)
    change = Change.of(middle)
    if not change.moved.any():
        return []
    reach = _FAR * _MIDDLE_PX
    if pivot_px is not None:
        starts = [(np.asarray(pivot_px) + 0.5) * scale - 0.5]
    else:
        starts = [p * _MIDDLE_PX / _COARSE_PX for p in _pivots(pictures[chosen])]
    found = []
    for start in starts:
        place = (float(start[0]), float(start[1]))
        part = learnt(middle, change, place, reach)
        for _ in range(0 if pivot_px is not None else _ROUNDS):
            if part is None:
                break
            part = _recentred(middle, change, part)
        if part is not None:
            x, y = (np.array(part.view.pivot_px) + 0.5) / scale - 0.5
            found.append(FoundPart((float(x), float(y)), part, chosen))
    return _distinct(
        sorted(found, key=lambda one: -one.explained), _APART * max(pictures.shape[1:])
    )


def _pivots(pictures: Single) -> list[Array]:
    """The most promising pivots [px of the coarse pictures], the best first."""
    coarse, _ = _scaled(pictures, _COARSE_PX)
    fewer = diverse(coarse, _FEWER)
    blurred = np.stack([cv2.GaussianBlur(p, (0, 0), _BLUR_PX) for p in coarse[fewer]])
    smooth = Change.of(blurred)
    active = (smooth.moved.mean(0) > _MOVED_SHARE).astype(np.uint8)
    if not active.any():
        return []
    height, width = active.shape
    y, x = np.mgrid[_STEP_PX / 2 : height : _STEP_PX, _STEP_PX / 2 : width : _STEP_PX]
    grid = np.column_stack([x.ravel(), y.ravel()])
    near = cv2.dilate(active, np.ones((41, 41), np.uint8))
    grid = grid[near[grid[:, 1].astype(int), grid[:, 0].astype(int)] > 0]
    scores = pivot_scores(blurred, smooth, grid, _REACH * _COARSE_PX).max(1)
    best = _apart(grid, scores, _TRIED, _APART * _COARSE_PX)
    sharp = Change.of(coarse[fewer])
    step = np.arange(-2, 3) * _FINE_PX
    about = np.array([(dx, dy) for dy in step for dx in step])
    fine = []
    for place in best:
        near_by = place + about
        scored = pivot_scores(coarse[fewer], sharp, near_by, _REACH * _COARSE_PX).max(1)
        fine.append((float(scored.max()), near_by[int(np.argmax(scored))]))
    return [place for _, place in sorted(fine, key=lambda one: -one[0])]


def _apart(places: Array, scores: Array, count: int, distance_px: float) -> list[Array]:
    """The places (n, 2) of the highest scores that are some distance from each other."""
    chosen: list[Array] = []
    for number in np.argsort(-scores):
        if all(np.hypot(*(places[number] - other)) > 1.5 * distance_px for other in chosen):
            chosen.append(places[number])
        if len(chosen) == count:
            break
    return chosen


def _recentred(pictures: Single, change: Change, part: TurningPart) -> TurningPart | None:
    """The part about a better pivot, from where it is seen shifted at its angles."""
    view = part.view
    model = CompositeModel.of(pictures, part.angle_rad, view.pivot_px, part.cover, view)
    fits = [
        model.fit(p, float(a), shifted=True) for p, a in zip(pictures, part.angle_rad, strict=True)
    ]
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
    fresh = learnt(pictures, change, (float(x), float(y)), view.rows * view.step_px)
    return fresh if fresh is not None and fresh.explained > 0.97 * part.explained else part


def _distinct(found: list[FoundPart], distance_px: float) -> list[FoundPart]:
    """Without those whose pivot is that of a better one."""
    kept: list[FoundPart] = []
    for one in found:
        away = [np.hypot(*np.subtract(one.pivot_px, other.pivot_px)) for other in kept]
        if all(distance > distance_px for distance in away):
            kept.append(one)
    return kept


def _scaled(pictures: Single, side_px: int) -> tuple[Single, float]:
    """Pictures brought to a longer side of ``side_px``, and by which factor."""
    scale = min(1.0, side_px / max(pictures.shape[1:]))
    if scale == 1.0:
        return pictures, 1.0
    small = [
        cv2.resize(p, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) for p in pictures
    ]
    return np.stack(small), scale
