"""The most promising pivots in pictures of which nothing is known: coarse, then finer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Single
from servosight.tracking.composite._hint import Hint
from servosight.tracking.composite.parts import Change, Reference, diverse, pivot_scores

_ROUGH_PX, _COARSE_PX = 80, 160  # the longer side
_STEP_PX, _BLURS_PX = 6.0, (2.5, 1.25, 0.6)  # of the coarse pictures
_FINE_PX = 2.0
_REACH = 0.45  # of the longer side: how far a part reaches
_TRIED, APART = 4, 0.06  # pivots, and their distance as a share of the longer side
_FEWER, _FEWEST = 14, 8

Referring = Callable[[Single, Change, Hint | None], list[Reference]]


def promising_pivots(
    pictures: Single, onto_scale: float, hint: Hint | None, referring: Referring
) -> list[Array]:
    """The most promising pivots, the best first, in pictures ``onto_scale`` times as large.

    ``referring`` says which parts of which pictures are turned.
    """
    coarse, scale = scaled(pictures, _COARSE_PX)
    fewer = diverse(coarse, _FEWER)
    blur_px, blurred, active = _where_active(coarse[fewer])
    near = hint.scaled(scale) if hint is not None else None
    if near is not None and near.region is not None:
        active |= near.region.astype(np.uint8)
    if not active.any():
        return []
    height, width = active.shape
    y, x = np.mgrid[_STEP_PX / 2 : height : _STEP_PX, _STEP_PX / 2 : width : _STEP_PX]
    grid = np.column_stack([x.ravel(), y.ravel()])
    about = cv2.dilate(active, np.ones((41, 41), np.uint8))
    grid = grid[about[grid[:, 1].astype(int), grid[:, 0].astype(int)] > 0]
    reach = _REACH * max(height, width)
    rough, half = scaled(blurred[diverse(blurred, _FEWEST)], _ROUGH_PX)  # nothing finer is left
    soft = near and replace(near, picture=_blurred(near.picture, blur_px)).scaled(half)
    fewer_cells = Change.of(rough)
    references = referring(rough, fewer_cells, soft)
    places = (grid + 0.5) * half - 0.5
    scores = pivot_scores(rough, fewer_cells, places, half * reach, references).max(1)
    best = _apart(grid, scores, _TRIED, APART * max(height, width))
    sharp = Change.of(coarse[fewer])
    references = referring(coarse[fewer], sharp, near)
    step = np.arange(-2, 3) * _FINE_PX
    around = np.array([(dx, dy) for dy in step for dx in step])
    fine = []
    for place in best:
        near_by = place + around
        scored = pivot_scores(coarse[fewer], sharp, near_by, reach, references).max(1)
        fine.append((float(scored.max()), near_by[int(np.argmax(scored))]))
    best = [place for _, place in sorted(fine, key=lambda one: -one[0])]
    return [(place + 0.5) * (onto_scale / scale) - 0.5 for place in best]


def _where_active(pictures: Single) -> tuple[float, Single, NDArray[np.uint8]]:
    """The blur [px], the pictures (n, height, width) blurred by it, and where they change (height,
    width): by less blur where none of the change is left, as of a needle of half a pixel."""
    for blur_px in _BLURS_PX:
        blurred = np.stack([_blurred(picture, blur_px) for picture in pictures])
        active = Change.of(blurred).often.astype(np.uint8)
        if active.any():
            break
    return blur_px, blurred, active


def _blurred(picture: Single, blur_px: float) -> Single:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), blur_px), np.float32)


def _apart(places: Array, scores: Array, count: int, distance_px: float) -> list[Array]:
    """The places (n, 2) of the highest scores that are some distance from each other."""
    chosen: list[Array] = []
    for number in np.argsort(-scores):
        if all(np.hypot(*(places[number] - other)) > 1.5 * distance_px for other in chosen):
            chosen.append(places[number])
        if len(chosen) == count:
            break
    return chosen


def scaled(pictures: Single, side_px: int) -> tuple[Single, float]:
    """Pictures brought to a longer side of ``side_px``, and by which factor."""
    scale = min(1.0, side_px / max(pictures.shape[1:]))
    if scale == 1.0:
        return pictures, 1.0
    small = [
        cv2.resize(p, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) for p in pictures
    ]
    return np.stack(small), scale
