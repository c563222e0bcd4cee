"""Features of pictures and their matches, each found once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Image

Index = NDArray[np.intp]
Match = tuple[Index, Array, Array]

_FEATURES = 1500
_CHANGED = 8  # grey levels of smoothed pictures, more than most pixels change
_SMOOTH_PX = 5
_ROOM_PX = 24  # for a feature's surroundings
_RATIO = 0.75  # of distances to the nearest and the next (Lowe 2004)


class Features:
    """SIFT features of a video's pictures, which several steps ask for; kept with the pictures.

    Of the part of them in which ``images`` differ, or of all of it where none are given: features
    that stay in place cost time, and tell nothing of what moves.
    """

    def __init__(self, images: Sequence[Image] = ()) -> None:
        self._part = _changing(images)
        # Without the precise upscaling OpenCV places all features a quarter of a pixel off.
        self._finder = cv2.SIFT.create(
            _FEATURES, contrastThreshold=0.02, enable_precise_upscale=True
        )
        self._found: dict[int, tuple[Image, Array, Any]] = {}
        self._matches: dict[tuple[int, int], Match] = {}

    def points_px(self, image: Image) -> Array:
        """Where the features of a picture are, x and y; (n, 2)."""
        return self._of(image)[0]

    def matched(self, first: Image, second: Image) -> Match:
        """Which features of the first are found in the second, (n,), and where in either, (n, 2)
        [px]."""
        pair = id(first), id(second)  # no other picture's as long as these are kept
        if pair not in self._matches:
            self._matches[pair] = _matched(self._of(first), self._of(second))
        return self._matches[pair]

    def _of(self, image: Image) -> tuple[Array, Any]:
        """Where a picture's features are, and their descriptors: None where there are none."""
        if id(image) not in self._found:
            part = np.ascontiguousarray(image[self._part])
            keypoints, described = self._finder.detectAndCompute(part, None)
            points = np.array([k.pt for k in keypoints], np.float64).reshape(-1, 2)
            corner = self._part[1].start or 0, self._part[0].start or 0
            self._found[id(image)] = image, points + corner, described
        return self._found[id(image)][1:]


def _changing(images: Sequence[Image]) -> tuple[slice, slice]:
    """Rows and columns of the box that holds all that differs between pictures, and some room; the
    whole picture where nothing does."""
    whole = slice(None), slice(None)
    if len(images) < 2:
        return whole
    smooth = [cv2.blur(image, (_SMOOTH_PX, _SMOOTH_PX)) for image in images]
    change = np.max(smooth, axis=0) - np.min(smooth, axis=0)
    differs = (change > float(np.median(change)) + _CHANGED).astype(np.uint8)
    x, y, width, height = cv2.boundingRect(cv2.erode(differs, np.ones((3, 3), np.uint8)))
    if width == 0:
        return whole
    rows = slice(max(y - _ROOM_PX, 0), y + height + _ROOM_PX)
    return rows, slice(max(x - _ROOM_PX, 0), x + width + _ROOM_PX)


def _matched(first: tuple[Array, Any], second: tuple[Array, Any]) -> Match:
    """Matches of features, by their descriptors."""
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
    return good, first[0][good], second[0][nearest[good]]
