"""Pixels that a predicting codec copied from the frame before: they carry no new information.

Such a codec skips a block that changed little. The block then shows the surface at its previous
angle, so its pixels would indicate, with high precision, that the angle has not changed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Array, Mask
from servosight.tracking.fit._polar import Sample

_BLOCK_PX = 8  # the smallest block that codecs copy as one
_SAME = 0.5  # share of a block's pixels; by chance a fifth are the same
_LEAST_NEW = 0.1  # of the information on the angle: less is not enough for a measurement


def copied_pixels(picture: NDArray[np.uint8], before: NDArray[np.uint8]) -> Mask:
    """The pixels (height, width) in blocks of which most are as in the picture before."""
    copied = np.empty(picture.shape, np.bool_)
    _mark_copied(picture, before, copied)
    return copied


@njit(cache=True, nogil=True)
def _mark_copied(picture, before, copied):  # type: ignore[no-untyped-def]
    """Fill ``copied``; a block cut off by the border is continued by its last row and column."""
    height, width = picture.shape
    for top in range(0, height, _BLOCK_PX):
        for left in range(0, width, _BLOCK_PX):
            same = 0
            for y in range(top, top + _BLOCK_PX):
                row, earlier = picture[min(y, height - 1)], before[min(y, height - 1)]
                for x in range(left, left + _BLOCK_PX):
                    same += row[min(x, width - 1)] == earlier[min(x, width - 1)]
            often = same > _SAME * _BLOCK_PX**2
            copied[top : top + _BLOCK_PX, left : left + _BLOCK_PX] = often


def without_copied(sample: Sample, copied: Mask | None) -> Sample:
    """The pixels of a sample that are not ``copied``.

    Where these hold too little information on the angle: all pixels, with the share of that
    information that lies in copied ones.
    """

    if copied is None:
        return sample
    stale = copied.reshape(-1).take(sample.pixels.index.take(sample.chosen))
    worth = sample.per_turn.astype(np.float64) ** 2
    share = float(worth[stale].sum() / max(worth.sum(), 1e-30))
    return (
        replace(sample, copied_share=share) if share > 1.0 - _LEAST_NEW else sample.within(~stale)
    )


def lag(angle: Array, copied_share: Array) -> Array:
    """The possible lag of each frame's angle, in its unit; (frames,).

    ``copied_share`` (frames,) is the weight in the angle of pixels copied from the frame before:
    they lag by as much as that frame did, and by the turn of the surface since.
    """
    number = np.arange(angle.size)
    fresh = copied_share < 0.5
    if not fresh.any():
        return np.zeros_like(angle)
    turned = np.abs(np.gradient(np.interp(number, number[fresh], angle[fresh])))
    behind = np.zeros_like(angle)
    for n in np.flatnonzero(copied_share):
        behind[n] = copied_share[n] * (behind[n - 1] + turned[n])
    return behind
