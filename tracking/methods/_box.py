"""The square on the moving part that determines its angle best."""

from __future__ import annotations

import cv2
import numpy as np
from scipy import ndimage

from servosight.models.core import Array, Image
from servosight.tracking.core import Box

_LARGEST_HALF_PX = 28


def choose_box(outline_px: Array, pivot_px: tuple[float, float], picture: Image) -> Box:
    """The square on the surface with most information on its angle (x, y, width, height).

    It stays within the surface's edge at any angle. The information is the sum of (dI/dangle)^2
    over its pixels (Robinson and Milanfar 2004).
    """
    shape = picture.shape
    cover = np.zeros(shape, np.uint8)
    cv2.fillPoly(cover, [np.round(outline_px).astype(np.int32)], 1)
    cover[[0, -1]] = 0
    cover[:, [0, -1]] = 0
    # The square may turn: its corners stay within a circle of half its diagonal.
    room = (ndimage.distance_transform_edt(cover) - 2.0) / np.sqrt(2.0)
    half = np.clip(np.floor(room), 0, _LARGEST_HALF_PX).astype(int)
    y, x = np.indices(shape)
    gy, gx = np.gradient(ndimage.gaussian_filter(picture.astype(np.float64), 1.0))
    power = (gy * (x - pivot_px[0]) - gx * (y - pivot_px[1])) ** 2
    gathered = np.pad(power.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    low_y, low_x = np.maximum(y - half, 0), np.maximum(x - half, 0)
    high_y, high_x = np.minimum(y + half + 1, shape[0]), np.minimum(x + half + 1, shape[1])
    worth = gathered[high_y, high_x] - gathered[low_y, high_x]
    worth += gathered[low_y, low_x] - gathered[high_y, low_x]
    worth[half < 6] = half[half < 6] - 6.0
    row, column = np.unravel_index(int(np.argmax(worth)), shape)
    size = int(max(half[row, column], 6))
    left = int(np.clip(column - size, 0, shape[1] - 2 * size - 1))
    top = int(np.clip(row - size, 0, shape[0] - 2 * size - 1))
    return left, top, 2 * size + 1, 2 * size + 1
