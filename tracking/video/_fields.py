"""Pictures that are woven of two fields, although the file does not say so: found by their lines.

Of what moves, each line lies between its neighbours less than between those two lines away, which
are of the same field. A converter that forgets the tag leaves such files.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single

_MOVES = 20  # grey levels
_LINES = np.ones((5, 1), np.uint8)
_FEWEST = 500  # pixels that move
_WOVEN = 1.1  # 2.5 where fields are woven, 0.3 to 0.6 in 17 clips in which they are not


class FieldOrder(Enum):
    """Which of a picture's two fields was exposed first, by FFmpeg's names."""

    TOP = "tff"
    BOTTOM = "bff"


def changes(run: Sequence[Image]) -> Array:
    """The mean change from each picture of a run to the next [grey levels], (pictures - 1,); of
    every fourth pixel in either direction."""
    thin = np.stack([image[::4, ::4] for image in run]).astype(np.int16)
    return np.asarray(np.abs(np.diff(thin, axis=0)).mean((1, 2)))


def most_different(run: Sequence[Image]) -> tuple[Image, Image] | None:
    """The two neighbouring pictures of a run between which most moves; None of a single one."""
    if len(run) < 2:
        return None
    number = int(np.argmax(changes(run)))
    return run[number], run[number + 1]


def woven_fields(pairs: Iterable[tuple[Image, Image]]) -> FieldOrder | None:
    """The order of the fields of which pictures are woven, from pairs of neighbouring ones uint8
    (height, width); None where they are whole, or where too little moves to tell.

    What rests tells whether fine lines of the scene would be taken for fields.
    """
    sums = np.zeros((2, 2))
    apart = np.zeros(2)
    count = 0
    for before, after in pairs:
        first, second = before.astype(np.float32), after.astype(np.float32)
        changed = (np.abs(first - second) > _MOVES).astype(np.uint8)
        moves = cv2.dilate(changed, _LINES) > 0  # the part may cover the other field's lines still
        middle = np.s_[2:-2]
        for row, mask in enumerate((moves[middle], ~moves[middle])):
            sums[row] += [np.abs(_off(first, lines)[mask]).sum() for lines in (1, 2)]
        count += int(moves[middle].sum())
        # Of the field exposed last a line is nearer to the next picture's first field.
        apart += [_beside(first, second, moves, odd) for odd in (1, 0)]
    if count < _FEWEST:
        return None
    moving, still = sums[:, 0] / np.maximum(sums[:, 1], 1.0)
    if moving < _WOVEN or still > _WOVEN:
        return None
    return FieldOrder.TOP if apart[0] < apart[1] else FieldOrder.BOTTOM


def _off(image: Single, lines: int) -> Single:
    """By how much each line differs from the mean of those so many above and below."""
    height = image.shape[0]
    around = image[2 - lines : height - 2 - lines] + image[2 + lines : height - 2 + lines]
    return np.asarray(image[2:-2] - 0.5 * around)


def _beside(first: Single, second: Single, moves: Mask, odd: int) -> float:
    """By how much the ``odd`` or even lines of a picture differ, where it moves, from the lines
    beside them in the next one; the sum."""
    rows = np.arange(2 + odd, first.shape[0] - 2, 2)
    apart = np.abs(first[rows] - 0.5 * (second[rows - 1] + second[rows + 1]))
    return float(apart[moves[rows]].sum())
