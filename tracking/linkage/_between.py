"""What two parts leave of the pictures, and how much of its change a strip from one part to the
other explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.core import Track, outline_at, turning

_BLUR_PX = 1.0
_ROOM_PX = 3
"""An outline may be off by so much."""
_FEWEST = 3

Strip = tuple[Array, Array]
"""Where a strip is sampled: shares of its length, and distances from its middle line [px]."""


@dataclass(frozen=True)
class BetweenParts:
    """Pictures (frames, height, width) with two parts that turn.

    ``bare`` (frames, height, width) is True where neither part covers the picture, ``change``
    (height, width) the variance of each pixel over these frames [grey levels^2]. The parts have
    ``pivots`` (2, 2) [px] and ``turns`` (2, frames, 2, 2), the rotations from their angle zero.
    """

    pictures: Single
    bare: Mask
    change: Single
    pivots: Array
    turns: Array

    @classmethod
    def of(
        cls, images: Sequence[Image], index: Sequence[int], parts: Sequence[Track]
    ) -> BetweenParts:
        """From pictures in which the camera stays in place, and the numbers of their frames."""
        smooth = [cv2.GaussianBlur(one.astype(np.float32), (0, 0), _BLUR_PX) for one in images]
        pictures = np.stack(smooth).astype(np.float32)
        bare = np.stack([_bare(one.shape, parts, n) for one, n in zip(images, index, strict=True)])
        count = np.maximum(bare.sum(0), 1)
        mean = np.where(bare, pictures, 0.0).sum(0) / count
        change = np.where(bare, (pictures - mean) ** 2, 0.0).sum(0) / count
        angles = np.deg2rad([part.angle_deg[list(index)] for part in parts])
        pivots = np.array([part.pivot_px for part in parts])
        return cls(pictures, bare, change.astype(np.float32), pivots, turning(angles))

    def carried(self, part: int, points: Array) -> Array:
        """Points (n, 2) of a part, from its pivot at angle zero, in each frame: (n, frames, 2)."""
        turned = np.einsum("kij,nj->nki", self.turns[part], points)
        return np.asarray(turned + self.pivots[part])

    def explained(self, first: Array, second: Array, strip: Strip) -> tuple[Array, Array]:
        """What strips from points to points (n, frames, 2) explain of the change where they pass,
        and that change, each line along them by itself, (n, lines) [grey levels^2 times samples].

        A sample of a strip explains what it does not change by itself from frame to frame.
        """
        along, across = strip
        away = second - first
        length = np.hypot(away[..., 0], away[..., 1])[..., None]
        normal = np.stack([-away[..., 1], away[..., 0]], -1) / np.maximum(length, 1e-9)
        place = (
            first[:, :, None, None]
            + away[:, :, None, None] * along[:, None, None]
            + normal[:, :, None, None] * across[:, None]
        )
        frames, height, width = self.pictures.shape
        last = np.array([width, height]) - 1
        x, y = np.moveaxis(np.clip(np.round(place).astype(np.intp), 0, last), -1, 0)
        frame = np.arange(frames)[:, None, None]
        bare = self.bare[frame, y, x]
        seen, change = self.pictures[frame, y, x], self.change[y, x]
        count = bare.sum(1)
        enough = count >= max(frames // 2, _FEWEST)
        mean = np.where(bare, seen, 0.0).sum(1) / np.maximum(count, 1)
        left = np.where(bare, (seen - mean[:, None]) ** 2, 0.0).sum(1)
        whole = np.where(bare, change, 0.0).sum(1)
        totals = (np.where(enough, one, 0.0).sum(1) / frames for one in (whole - left, whole))
        gain, passed = totals
        return np.asarray(gain, np.float64), np.asarray(passed, np.float64)


def _bare(shape: tuple[int, ...], parts: Sequence[Track], frame: int) -> Mask:
    """Where neither part is in a frame, (height, width)."""
    cover = np.zeros(shape, np.uint8)
    for part in parts:
        outline = outline_at(part, float(part.angle_deg[frame]))
        cv2.fillPoly(cover, [np.round(outline).astype(np.int32)], 1)
    size = 2 * _ROOM_PX + 1
    return np.asarray(cv2.dilate(cover, np.ones((size, size), np.uint8)) == 0)
