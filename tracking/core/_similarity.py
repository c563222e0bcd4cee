"""The motion on which most matched features agree."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Mask


def most_agree_on(
    before: Any, after: Any, within_px: float, least: int
) -> tuple[Array, Mask] | None:
    """The similarity (2, 3) on which most features (n, 2) agree ``within_px``, and which do (n,).

    None where these are fewer than ``least``. RANSAC with a fixed seed (Fischler and Bolles 1981).

    >>> at = np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 7.0], [8.0, 8.0], [3.0, 5.0]])
    >>> shift = np.array([[2.0, 1.0]] * 4 + [[9.0, 9.0]])
    >>> motion, same = most_agree_on(at, at + shift, 0.5, least=4)
    >>> np.round(motion[:, 2]).tolist(), same.tolist()
    ([2.0, 1.0], [True, True, True, True, False])
    """
    if len(before) < least:
        return None
    cv2.setRNGSeed(1)
    found: tuple[Any, Any] = cv2.estimateAffinePartial2D(
        before, after, method=cv2.RANSAC, ransacReprojThreshold=within_px
    )
    matrix, inlier = found
    if matrix is None or inlier.sum() < least:
        return None
    return np.asarray(matrix, np.float64), inlier.ravel() > 0
