"""Features of pictures and their matches, each found once."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Image

Index = NDArray[np.intp]
Match = tuple[Index, Array, Array]

_FEATURES = 1500
_RATIO = 0.75  # of distances to the nearest and the next (Lowe 2004)


class Features:
    """SIFT features of a video's pictures, which several steps ask for; kept with the pictures."""

    def __init__(self) -> None:
        # Without the precise upscaling OpenCV places all features a quarter of a pixel off.
        self._finder = cv2.SIFT.create(
            _FEATURES, contrastThreshold=0.02, enable_precise_upscale=True
        )
        self._found: dict[int, tuple[Image, Any, Any]] = {}
        self._matches: dict[tuple[int, int], Match] = {}

    def points_px(self, image: Image) -> Array:
        """Where the features of a picture are, x and y; (n, 2)."""
        points = [keypoint.pt for keypoint in self._of(image)[0]]
        return np.array(points, np.float64).reshape(-1, 2)

    def matched(self, first: Image, second: Image) -> Match:
        """Which features of the first are found in the second, (n,), and where in either, (n, 2)
        [px]."""
        pair = id(first), id(second)  # no other picture's as long as these are kept
        if pair not in self._matches:
            self._matches[pair] = _matched(self._of(first), self._of(second))
        return self._matches[pair]

    def _of(self, image: Image) -> tuple[Any, Any]:
        if id(image) not in self._found:
            self._found[id(image)] = image, *self._finder.detectAndCompute(image, None)
        return self._found[id(image)][1:]


def _matched(first: tuple[Any, Any], second: tuple[Any, Any]) -> Match:
    """Matches of keypoints and descriptors, which are None where nothing is found."""
    if any(one[1] is None or len(one[1]) < 2 for one in (first, second)):
        return np.empty(0, np.intp), np.empty((0, 2)), np.empty((0, 2))
    # By a product of matrices: faster than comparing pairs, and exact, as SIFT's numbers are whole.
    before, after = (np.asarray(one[1], np.float32) for one in (first, second))
    apart = (before**2).sum(1)[:, None] - 2.0 * before @ after.T + (after**2).sum(1)
    rows = np.arange(len(before))
    nearest = np.argmin(apart, axis=1)
    least = apart[rows, nearest]
    apart[rows, nearest] = np.inf
    good = np.flatnonzero(least < _RATIO**2 * apart.min(1))
    places = [np.array([k.pt for k in one[0]], np.float64) for one in (first, second)]
    return good, places[0][good], places[1][nearest[good]]
