"""A picture's pixels by rings about the pivot: a part's own are a few stretches of these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numba import njit
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

    @property
    def compiled(self) -> tuple[Any, ...]:
        """What compiled passes take of it: the rings' places, and of each pixel polar angle,
        radius, delay and place in the flattened picture."""
        table = self.pixels
        return self.start, table.phi_rad, table.radius_px, table.delay, table.index

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


@njit(cache=True, nogil=True, error_model="numpy")
def turned(lattice, angle_rad, motion):  # type: ignore[no-untyped-def]
    """``PolarGrid.lattice`` turned to an angle, on the circle of a table of pixels that are turned
    by ``Exposure.by_row``."""
    lowest = angle_rad + lattice[0] - motion[2]
    turn = angle_rad + (np.mod(lowest, 2 * np.pi) - lowest)
    return turn + lattice[0], lattice[1], lattice[2], lattice[3]


@njit(cache=True, nogil=True, error_model="numpy")
def stretch(run, start, phi, place, motion):  # type: ignore[no-untyped-def]
    """The first pixel that may show a run of cells of a turned lattice, and that behind the last;
    ``start`` and ``phi`` are those of ``RingPixels``."""
    first, last = start[run[0]], start[run[0] + 1]
    begins = place[0] + (run[1] - 0.5) / place[1] - motion[2]
    ends = place[0] + (run[2] + 0.5) / place[1] + motion[2]
    ring = phi[first:last]
    return first + np.searchsorted(ring, begins), first + np.searchsorted(ring, ends)
