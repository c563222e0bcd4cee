"""What two parts leave of the pictures, and how much of its change a strip from one part to the
other explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit

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
        totals = np.zeros((2, len(first), strip[1].size))
        _sum_explained(
            (self.pictures, self.bare, self.change),
            (np.asarray(first, float), np.asarray(second, float)),
            strip,
            max(len(self.pictures) // 2, _FEWEST),
            totals,
        )
        gain, passed = totals / len(self.pictures)
        return gain, passed


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_explained(scene, ends, strip, enough, totals):  # type: ignore[no-untyped-def]
    """Adds up what strips explain, ``totals[0]`` (n, lines), and the change there, ``totals[1]``,
    of samples that are bare in ``enough`` frames."""
    pictures, bare, change = scene
    first, second = ends
    along, across = strip
    frames, height, width = pictures.shape
    for i in range(first.shape[0]):
        for m in range(along.size):
            for j in range(across.size):
                count, mean, square, whole = 0, 0.0, 0.0, 0.0
                for k in range(frames):
                    dx = second[i, k, 0] - first[i, k, 0]
                    dy = second[i, k, 1] - first[i, k, 1]
                    aside = across[j] / max(np.hypot(dx, dy), 1e-9)
                    x = np.rint(first[i, k, 0] + along[m] * dx - aside * dy)
                    y = np.rint(first[i, k, 1] + along[m] * dy + aside * dx)
                    u = int(min(max(x, 0.0), width - 1.0))
                    v = int(min(max(y, 0.0), height - 1.0))
                    if not bare[k, v, u]:
                        continue
                    # Mean and sum of squares about it, value by value (Welford 1962).
                    count += 1
                    away = pictures[k, v, u] - mean
                    mean += away / count
                    square += away * (pictures[k, v, u] - mean)
                    whole += change[v, u]
                if count >= enough:
                    totals[0, i, j] += whole - square
                    totals[1, i, j] += whole


def _bare(shape: tuple[int, ...], parts: Sequence[Track], frame: int) -> Mask:
    """Where neither part is in a frame, (height, width)."""
    cover = np.zeros(shape, np.uint8)
    for part in parts:
        outline = outline_at(part, float(part.angle_deg[frame]))
        cv2.fillPoly(cover, [np.round(outline).astype(np.int32)], 1)
    size = 2 * _ROOM_PX + 1
    return np.asarray(cv2.dilate(cover, np.ones((size, size), np.uint8)) == 0)
