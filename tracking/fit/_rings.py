"""A picture's pixels by rings about the pivot: a part's own are a few stretches of these."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Mask
from servosight.tracking.fit._polar import Pixels, PolarGrid

_GAP = 6  # so many unused cells do not divide a run


@dataclass(frozen=True)
class RingPixels:
    """A picture's pixels sorted by rings about a pivot, one for each lattice row, and by angle.

    ``start`` (rows + 1,) are the rings' places in the table ``pixels``, each twice round.
    """

    pixels: Pixels
    start: NDArray[np.intp]

    @classmethod
    def about(cls, grid: PolarGrid, shape: tuple[int, ...], every: int = 1) -> RingPixels:
        """The pixels of a picture of ``shape`` (height, width); with ``every`` > 1 a thinning."""
        table = Pixels.about(grid, shape, every)
        # Numbers of 16 bits are sorted by their digits, ten times as fast.
        ring = np.rint((table.radius_px - grid.radius_px) / grid.step_px).astype(np.int16)
        order = np.argsort(ring, kind="stable")
        order = order[np.searchsorted(ring[order], 0) :]
        return cls(table.at(order), np.searchsorted(ring[order], np.arange(grid.rows + 1)))


def runs_of(used: Mask) -> NDArray[np.intp]:
    """Row, first and last column of the runs of cells in use (rows, columns); (runs, 3).

    >>> runs_of(np.array([[0, 1, 1, 0], [0, 0, 0, 0], [1, 0, 0, 1]]) > 0).tolist()
    [[0, 1, 2], [2, 0, 3]]
    """
    wide = np.pad(used, ((0, 0), (_GAP, _GAP)))
    closed = cv2.morphologyEx(
        wide.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((1, _GAP + 1), np.uint8)
    )
    edge = np.diff(closed.astype(np.int8), axis=1, prepend=0, append=0)
    row, first = np.nonzero(edge > 0)
    return np.column_stack([row, first - _GAP, np.nonzero(edge < 0)[1] - _GAP - 1])
