"""Two tracks compared: are they of the same part, and which one is surer."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from servosight.models.core import Image, Mask, Single
from servosight.tracking.acquisition import swept
from servosight.tracking.core import Track

_LEAST_FRAMES, _ALIKE = 8, 0.98
_MORE_FRAMES = 0.2  # of all
_SMALLER = 4  # pictures in which change is compared


def alike(one: Track, other: Track) -> bool:
    """Whether two tracks are of the same part: it turns alike."""
    both = one.found & other.found
    if np.count_nonzero(both) < _LEAST_FRAMES:
        return False
    return bool(np.corrcoef(one.angle_deg[both], other.angle_deg[both])[0, 1] > _ALIKE)


def beside(one: Track, other: Track) -> bool:
    """Whether two tracks are of parts that lie beside each other: the circles in which they turn do
    not meet."""
    away_px = float(np.hypot(*np.subtract(one.pivot_px, other.pivot_px)))
    return away_px > _reach_px(one) + _reach_px(other)


def change_of(track: Track, images: Sequence[Image]) -> float:
    """How much changes in pictures (height, width) of one camera position where a part passes: the
    sum of the variances of their pixels [grey levels^2]."""
    return float(_changes(images)[_passed(track, images)].sum())


def changes_beside(track: Track, images: Sequence[Image], share: float) -> bool:
    """Whether the pictures change where a part does not pass by more than this share of what they
    change by where it does."""
    changes, inside = _changes(images), _passed(track, images)
    return float(changes[~inside].sum()) > share * float(changes[inside].sum())


def _changes(images: Sequence[Image]) -> Single:
    """The variance of each pixel of the pictures, made smaller."""
    small = [cv2.resize(one, _size(images), interpolation=cv2.INTER_AREA) for one in images]
    return np.asarray(np.stack(small).astype(np.float32).var(0))


def _passed(track: Track, images: Sequence[Image]) -> Mask:
    """Where a part passes in these smaller pictures."""
    passed = swept(track, images[0].shape).astype(np.uint8)
    return np.asarray(cv2.resize(passed, _size(images), interpolation=cv2.INTER_NEAREST) > 0)


def _size(images: Sequence[Image]) -> tuple[int, int]:
    height, width = images[0].shape
    return max(width // _SMALLER, 1), max(height // _SMALLER, 1)


def _reach_px(track: Track) -> float:
    """How far a part reaches from its pivot."""
    return float(np.hypot(*(track.outline_px - np.array(track.pivot_px)).T).max())


def surest(one: Track, other: Track) -> Track:
    """That of two tracks of one part which finds it in far more of the frames, else the one with
    the smaller sigma in most, with what all its angles share; the first one where both are alike.
    """
    more = float(np.mean(one.found)) - float(np.mean(other.found))
    if abs(more) > _MORE_FRAMES:
        return one if more > 0.0 else other
    return min(one, other, key=lambda track: float(np.median(track.sigma_deg[track.found])))
