"""Matching features of two pictures."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array

Index = NDArray[np.intp]

_RATIO = 0.75  # of distances to the nearest and the next (Lowe 2004)


def matched(first: tuple[Any, Any], second: tuple[Any, Any]) -> tuple[Index, Array, Array]:
    """Which features of the first are found in the second, (n,), and where in either, (n, 2) [px].

    Each is what OpenCV's ``detectAndCompute`` returns.
    """
    if any(one[1] is None or len(one[1]) < 2 for one in (first, second)):
        return np.empty(0, np.intp), np.empty((0, 2)), np.empty((0, 2))
    pairs = cv2.BFMatcher(cv2.NORM_L2).knnMatch(first[1], second[1], k=2)
    good = [p[0] for p in pairs if len(p) == 2 and p[0].distance < _RATIO * p[1].distance]
    before = np.array([first[0][match.queryIdx].pt for match in good], np.float64)
    after = np.array([second[0][match.trainIdx].pt for match in good], np.float64)
    index = np.array([match.queryIdx for match in good], np.intp)
    return index, before.reshape(-1, 2), after.reshape(-1, 2)
