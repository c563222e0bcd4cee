"""The camera's motion by all grey levels of the background, from a rough one by features.

Lucas and Kanade with the roles of the pictures exchanged (Baker and Matthews 2004, inverse
compositional): what depends on the background alone is computed once. Where few features are found,
as before a plain wall, those leave errors of a pixel and more.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Mask, Single

_MOST_PIXELS, _LEAST_PIXELS = 6000, 300
_LEAST_SLOPE = 1.0  # grey levels per pixel
_ROUNDS, _ENOUGH_PX = 8, 0.005
_FARTHEST_PX = 4.0  # from the rough motion: farther away it is another place that looks the same
_HUBER = 1.5


@dataclass(frozen=True)
class Background:
    """The pixels of a background whose grey level depends most on the camera's motion.

    ``place_px`` (pixels, 2) from ``middle_px``, ``level`` (pixels,), and ``rows`` (4, pixels): the
    slopes by shift in x and y, turn [rad] and relative size.
    """

    middle_px: Array
    place_px: Array
    level: Array
    rows: Array

    @classmethod
    def of(cls, picture: Single, known: Mask) -> Background | None:
        """From a picture (height, width) where it is known; None where hardly anything is seen."""
        by_x, by_y = (cv2.Sobel(picture, cv2.CV_32F, *d, scale=0.125) for d in ((1, 0), (0, 1)))
        inner = cv2.erode(known.astype(np.uint8), np.ones((5, 5), np.uint8), borderValue=0) > 0
        slope = np.where(inner, np.hypot(by_x, by_y), 0.0)
        seen = np.flatnonzero(slope > _LEAST_SLOPE)
        if seen.size < _LEAST_PIXELS:
            return None
        if seen.size > _MOST_PIXELS:
            steepest = np.argpartition(slope.ravel()[seen], -_MOST_PIXELS)[-_MOST_PIXELS:]
            seen = seen[steepest]
        y, x = np.divmod(seen, picture.shape[1])
        place = np.column_stack([x, y]).astype(float)
        middle = place.mean(0)
        place -= middle
        gx, gy = by_x.ravel()[seen].astype(float), by_y.ravel()[seen].astype(float)
        turn, size = place[:, 0] * gy - place[:, 1] * gx, place[:, 0] * gx + place[:, 1] * gy
        level = picture.ravel()[seen].astype(float)
        return cls(middle, place, level, np.stack([gx, gy, turn, size]))

    def onto(self, picture: Single, rough: Array) -> Array:
        """The motion (2, 3) that takes the background to a picture, from a rough one; the rough one
        where this leads nowhere."""
        motion = rough
        for _ in range(_ROUNDS):
            at = (self.place_px + self.middle_px) @ motion[:, :2].T + motion[:, 2]
            wide = -(-len(at) // 1024) * 1024
            x, y = (np.resize(v, wide).astype(np.float32).reshape(-1, 1024) for v in at.T)
            seen = cv2.remap(
                picture, x, y, cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_CONSTANT, borderValue=float("nan"),
            ).ravel()[: len(at)].astype(float)  # fmt: skip
            inside = np.isfinite(seen)
            if inside.sum() < _LEAST_PIXELS:
                return rough
            left = seen - self.level
            left = np.where(inside, left - np.median(left[inside]), 0.0)
            scale = 1.4826 * float(np.median(np.abs(left[inside]))) + 0.3
            weight = inside / np.maximum(1.0, np.abs(left) / (_HUBER * scale))
            weight *= np.abs(left) < 6.0 * scale
            normal = (self.rows * weight) @ self.rows.T
            size = np.sqrt(np.diag(normal))
            if size.min() == 0.0 or np.linalg.cond(normal / np.outer(size, size)) > 1e6:
                return rough
            step = np.linalg.solve(normal, (self.rows * weight) @ left)
            motion = self._less(motion, step)
            if np.hypot(*step[:2]) < _ENOUGH_PX:
                break
        away = (motion - rough)[:, :2] @ self.middle_px + (motion - rough)[:, 2]
        return motion if float(np.hypot(*away)) < _FARTHEST_PX else rough

    def _less(self, motion: Array, step: Array) -> Array:
        """The motion after the inverse of a small one (4,) about the middle of the pixels."""
        turn, size = step[2:]
        small = np.array([[1.0 + size, -turn], [turn, 1.0 + size]])
        back = np.linalg.inv(small)
        moved = self.middle_px + step[:2]
        matrix = motion[:, :2] @ back
        shift = motion[:, 2] + motion[:, :2] @ (self.middle_px - back @ moved)
        return np.column_stack([matrix, shift])
