"""Features of pictures and their matches, each found once, where the pictures differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Image
from servosight.tracking.core._parallel import threaded
from servosight.tracking.core._track import Box

Index = NDArray[np.intp]
Match = tuple[Index, Array, Array]

_FEATURES = 1500
_ENOUGH_PX = 640 * 480  # larger pictures are made smaller: finding them takes as long as that
_SMALLER = 0.9  # less is not worth the resampling
_RATIO = 0.75  # of distances to the nearest and the next (Lowe 2004)
_CELL_PX, _EVERY = 8, 2  # what changes is looked for in cells, on one of so many rows and columns
_STEP = 4.0  # grey levels, beyond twice the change by noise
_MARGIN_PX = 40  # about what changes: a feature's surroundings tell it from others


class Features:
    """SIFT features of a video's pictures, which several steps ask for; kept with the pictures.

    Of the ``within`` (x, y, width, height) of each picture, of all of it if None.
    """

    def __init__(self, within: Box | None = None) -> None:
        # Without the precise upscaling OpenCV places all features a quarter of a pixel off.
        self._finder = cv2.SIFT.create(
            _FEATURES, contrastThreshold=0.02, enable_precise_upscale=True
        )
        self._within = within
        self._found: dict[int, tuple[Image, Array, Any]] = {}
        self._matches: dict[tuple[int, int], Match] = {}

    @classmethod
    def of_change(cls, images: Sequence[Image]) -> Features:
        """Of what differs between pictures of one camera position: what rests tells nothing."""
        return cls(changing(images))

    def find(self, images: Sequence[Image]) -> None:
        """Find the features of several pictures at once."""
        new = [image for image in images if id(image) not in self._found]
        for image, found in zip(new, threaded(self._found_in, new), strict=True):
            self._found[id(image)] = image, *found

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
        self.find([image])
        return self._found[id(image)][1:]

    def _found_in(self, image: Image) -> tuple[Array, Any]:
        x, y, width, height = self._within or (0, 0, *image.shape[1::-1])
        part: Any = np.ascontiguousarray(image[y : y + height, x : x + width])
        scale = float(np.sqrt(_ENOUGH_PX / (width * height)))
        if scale < _SMALLER:
            size = round(scale * width), round(scale * height)
            part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
        keys, descriptors = self._finder.detectAndCompute(part, None)
        points = np.array([key.pt for key in keys], np.float64).reshape(-1, 2)
        larger = np.array([width, height]) / part.shape[1::-1]
        return (points + 0.5) * larger - 0.5 + (x, y), descriptors


def changing(images: Sequence[Image]) -> Box | None:
    """The box (x, y, width, height) about all that differs between pictures (height, width) by
    more than noise, with a margin; None where nothing does."""
    some = np.stack([image[::_EVERY, ::_EVERY] for image in images])
    away = (some.max(0) - some.min(0)).astype(np.float32)
    cell = _CELL_PX // _EVERY
    size = max(away.shape[1] // cell, 1), max(away.shape[0] // cell, 1)
    coarse = cv2.resize(away, size, interpolation=cv2.INTER_AREA)
    noise = float(np.quantile(coarse, 0.25))
    moved = cv2.morphologyEx(
        (coarse > 2.0 * noise + _STEP).astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8)
    )
    if not moved.any():
        return None
    x, y, width, height = cv2.boundingRect(moved)
    shape = np.array(images[0].shape[1::-1])
    low = np.maximum(np.array([x, y]) * _CELL_PX - _MARGIN_PX, 0)
    high = np.minimum(np.array([x + width, y + height]) * _CELL_PX + _MARGIN_PX, shape)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _matched(first: tuple[Array, Any], second: tuple[Array, Any]) -> Match:
    """Matches of points and descriptors, which are None where nothing is found."""
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
