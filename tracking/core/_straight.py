"""Features along straight edges, as in the grain of wood, which tell a shift across these alone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask
from servosight.tracking.core._similarity import most_agree_on

_WINDOW = 21  # that of the optical flow
_STRAIGHT = 0.1  # times as much change along the edge as across it
_MOSTLY = 0.3  # of all features
_AS_WELL = 0.95  # of the features that agree on another motion: none explains them as well
_ROUNDS = 2
_MEDIAN_ROUNDS, _NEAR_PX = 8, 0.05
_DETERMINED = 0.1  # of the largest singular value: what tells less is left as it is
_STILL = np.eye(2, 3)


def edge_normals(picture: Image, points: Array) -> Array:
    """Unit vectors across the straight edges on which features (n, 2) lie (n, 2); (0, 0) for
    features whose surroundings change in all directions.

    By the eigenvectors of the structure tensor (Harris and Stephens 1988).

    >>> stripes = np.tile(np.array([0, 0, 90, 90], np.uint8), (40, 10))
    >>> np.abs(edge_normals(stripes, np.array([[20.0, 20.0]]))).tolist()
    [[1.0, 0.0]]
    """
    tensor = cv2.cornerEigenValsAndVecs(picture, _WINDOW, 3)
    x, y = np.round(points).astype(int).T
    first, second = tensor[y, x, 0], tensor[y, x, 1]
    larger = first >= second
    vectors = np.where(larger[:, None], tensor[y, x, 2:4], tensor[y, x, 4:6])
    least, most = np.minimum(first, second), np.maximum(first, second)
    return np.asarray(np.where((least < _STRAIGHT * most)[:, None], vectors, 0.0), np.float64)


def mostly_straight(normals: Array) -> bool:
    """Whether many of the features with these normals (n, 2) lie on straight edges."""
    return float(np.mean(normals.any(axis=1))) > _MOSTLY


def most_agree_across(
    before: Any, after: Any, normals: Array, within_px: float, least: int
) -> tuple[Array, Mask] | None:
    """As ``most_agree_on``, with features on straight edges compared across these.

    Optical flow leaves such a feature anywhere along its edge. What no feature tells, as a shift
    along edges that are all parallel, is taken to be none.

    >>> at = np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 7.0], [8.0, 8.0], [3.0, 5.0]])
    >>> slid = at + np.array([[0.0, s] for s in (3.0, 1.0, -4.0, 2.0, 0.5)])
    >>> motion, same = most_agree_across(at, slid, np.tile([1.0, 0.0], (5, 1)), 0.5, least=4)
    >>> bool(np.allclose(motion, np.eye(2, 3))), same.all()
    (True, np.True_)
    """
    if len(before) < least:
        return None
    full = ~normals.any(axis=1)
    tried: Iterable[tuple[Array, Mask] | None] = (
        most_agree_on(before[full], after[full], within_px, least),
        most_agree_on(before, after, within_px, least),
    )
    shifted = _median_shift(before, after, normals)
    motions = [_STILL, shifted, *(one[0] for one in tried if one is not None)]
    counts = [np.sum(_off_px(before, after, normals, one) < within_px) for one in motions]
    motion = _STILL if counts[0] > _AS_WELL * max(counts) else motions[int(np.argmax(counts))]
    same = _off_px(before, after, normals, motion) < within_px
    for _ in range(_ROUNDS):
        if same.sum() < least:
            return None
        motion = _least_squares(before[same], after[same], normals[same], motion)
        same = _off_px(before, after, normals, motion) < within_px
    return (motion, same) if same.sum() >= least else None


def _off_px(before: Any, after: Any, normals: Array, motion: Array) -> Array:
    """How far from where they are found a motion brings features (n, 2), across an edge where they
    lie on a straight one [px] (n,)."""
    left = before @ motion[:, :2].T + motion[:, 2] - after
    across = np.abs(np.einsum("ij,ij->i", left, normals))
    return np.asarray(np.where(normals.any(axis=1), across, np.hypot(*left.T)))


def _median_shift(before: Any, after: Any, normals: Array) -> Array:
    """The shift (2, 3) with the least sum of distances, by least squares with weights (IRLS)."""
    gone = after - before
    straight = normals.any(axis=1)
    across = np.einsum("ij,ij->i", gone, normals)[straight]
    rows = np.concatenate([np.tile(np.eye(2), (int(np.sum(~straight)), 1)), normals[straight]])
    right = np.concatenate([gone[~straight].ravel(), across])
    motion, left = _STILL.copy(), np.ones(len(right))
    for _ in range(_MEDIAN_ROUNDS):
        weight = 1.0 / np.sqrt(np.maximum(np.abs(left), _NEAR_PX))
        motion[:, 2] = np.linalg.lstsq(weight[:, None] * rows, weight * right, _DETERMINED)[0]
        left = right - rows @ motion[:, 2]
    return motion


def _least_squares(before: Any, after: Any, normals: Array, motion: Array) -> Array:
    """The similarity (2, 3) near another one that is best in the directions that features tell."""
    middle = before.mean(axis=0)
    x, y = (before - middle).T
    size = max(float(np.sqrt((x**2 + y**2).mean())), 1e-9)
    one, none = np.ones(len(x)), np.zeros(len(x))
    along_x = np.column_stack([x / size, -y / size, one, none])
    along_y = np.column_stack([y / size, x / size, none, one])
    gone = after - before @ motion[:, :2].T - motion[:, 2]
    straight = normals.any(axis=1)
    nx, ny = normals[straight].T
    rows = np.concatenate([
        along_x[~straight], along_y[~straight],
        nx[:, None] * along_x[straight] + ny[:, None] * along_y[straight],
    ])  # fmt: skip
    right = np.concatenate([*gone[~straight].T, nx * gone[straight, 0] + ny * gone[straight, 1]])
    grown, turned, *shift = np.linalg.lstsq(rows, right, rcond=_DETERMINED)[0]
    change = np.array([[grown, -turned], [turned, grown]]) / size
    found = motion.copy()
    found[:, :2] += change
    found[:, 2] += np.array(shift) - change @ middle
    return np.asarray(found, np.float64)
