"""The lines around a part."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Mask

_PIECE = 0.2  # of the largest piece's area; smaller ones are noise


def contour(cover: Mask) -> Array:
    """Around a part (points, 2); around all of its pieces, as the spokes of a plain wheel are."""
    large = contours(cover, cv2.RETR_EXTERNAL, _PIECE)
    if len(large) == 1:
        return large[0]
    hull: Any = cv2.convexHull(np.concatenate(large).astype(np.float32))
    return np.asarray(hull[:, 0, :], np.float64)


def contours(cover: Mask, which: int, share: float) -> list[Array]:
    """The contours (points, 2) that enclose some share of the largest one's area at least."""
    found, _ = cv2.findContours(cover.astype(np.uint8), which, cv2.CHAIN_APPROX_NONE)
    sizes = np.array([cv2.contourArea(line) for line in found])
    large = (line for line, size in zip(found, sizes, strict=True) if size >= share * sizes.max())
    return [np.asarray(line[:, 0, :], np.float64) for line in large]
