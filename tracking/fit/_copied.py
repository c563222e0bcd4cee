"""Codecs that draw a picture from the one before it: where they only copied, nothing new is told.

Such a codec spends nothing on a block that changed too little to be worth it. The block then shows
the surface where it was, so its pixels say that the angle stands still, and say so exactly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Mask
from servosight.tracking.fit._polar import Sample

_BLOCK_PX = 8  # the smallest block that codecs copy as one
_SAME = 0.5  # share of a block's pixels; by chance a fifth are the same
_LEAST_NEW = 0.1  # of what tells of the angle: less is not enough to measure by


def copied(picture: NDArray[np.uint8], before: NDArray[np.uint8]) -> Mask:
    """The pixels (height, width) in blocks of which most are as in the picture before."""
    height, width = picture.shape
    room = ((0, -height % _BLOCK_PX), (0, -width % _BLOCK_PX))
    same = np.pad(picture == before, room, mode="edge")
    blocks = same.reshape(same.shape[0] // _BLOCK_PX, _BLOCK_PX, -1, _BLOCK_PX)
    often = blocks.sum((1, 3), np.uint8) > _SAME * _BLOCK_PX**2
    return np.asarray(often.repeat(_BLOCK_PX, 0).repeat(_BLOCK_PX, 1)[:height, :width])


def news(sample: Sample, old: Mask | None) -> Sample:
    """The pixels of a sample that are not ``old``; or, where these tell next to nothing, all of
    them, and the share that the old ones have in what they tell."""
    if old is None:
        return sample
    stale = old.reshape(-1).take(sample.pixels.index.take(sample.chosen))
    worth = sample.per_turn.astype(np.float64) ** 2
    share = float(worth[stale].sum() / max(worth.sum(), 1e-30))
    return replace(sample, held=share) if share > 1.0 - _LEAST_NEW else sample.within(~stale)


def lag(angle: Array, held: Array) -> Array:
    """How far behind each frame's angle may be, in its unit; (frames,).

    ``held`` (frames,) is the share that pixels copied from the frame before have in it: they lag
    by as much as that frame did, and by what the surface turned since.
    """
    number = np.arange(angle.size)
    fresh = held < 0.5
    if not fresh.any():
        return np.zeros_like(angle)
    turned = np.abs(np.gradient(np.interp(number, number[fresh], angle[fresh])))
    behind = np.zeros_like(angle)
    for n in np.flatnonzero(held):
        behind[n] = held[n] * (behind[n - 1] + turned[n])
    return behind
