"""Pixels that a predicting codec copied from the frame before: they carry no new information.

Such a codec skips a block that changed little. The block then shows the surface at its previous
angle, so its pixels would indicate, with high precision, that the angle has not changed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Array, Mask
from servosight.tracking.fit._polar import NONE_STALE, Sample

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
    """Fill ``copied``; a block that the border cuts off is judged by what is in the picture."""
    height, width = picture.shape
    same = np.empty(width, np.uint8)
    for top in range(0, height, _BLOCK_PX):
        rows = min(_BLOCK_PX, height - top)
        same[:] = 0
        for y in range(top, top + rows):
            row, earlier = picture[y], before[y]
            for x in range(width):
                same[x] += row[x] == earlier[x]
        for left in range(0, width, _BLOCK_PX):
            block = same[left : left + _BLOCK_PX]
            count = 0
            for number in block:
                count += number
            often = count > _SAME * rows * block.size
            for y in range(top, top + rows):
                for x in range(left, left + block.size):
                    copied[y, x] = often


def stale(sample: Callable[[], Sample], copied: Mask | None) -> tuple[Mask, float]:
    """Which pixels of a picture are to be left out as old, by their place in it, and 0.

    Where the rest of a ``sample`` holds too little information on the angle: none, and the share of
    that information that lies in ``copied`` ones.
    """
    if copied is None:
        return NONE_STALE, 0.0
    flat, whole = copied.reshape(-1), sample()
    share = _share(flat, whole.pixels.index, whole.chosen, whole.per_turn)
    return (NONE_STALE, share) if share > 1.0 - _LEAST_NEW else (flat, 0.0)


@njit(cache=True, nogil=True)
def _share(marked, index, chosen, per_turn):  # type: ignore[no-untyped-def]
    """The share of the information on the angle that lies in marked pixels."""
    own = total = 0.0
    for i in range(chosen.size):
        worth = np.float64(per_turn[i]) ** 2
        total += worth
        own += worth if marked[index[chosen[i]]] else 0.0
    return own / max(total, 1e-30)


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
