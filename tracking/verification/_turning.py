"""How well a picture turned about a pivot explains a frame, at every angle at once.

In polar coordinates a turn is a shift, so that the sum of squared differences at all angles is a
few correlations, which the fast Fourier transform gives. No start angle is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import fft

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import most_threads


@dataclass(frozen=True)
class PolarView:
    """A polar raster of ``rows`` radii, ``step_px`` apart, and ``columns`` directions.

    The directions are counter-clockwise as seen, the first one to the right; ``pivot_px`` is x, y.
    """

    pivot_px: tuple[float, float]
    rows: int
    columns: int
    step_px: float = 1.0

    @classmethod
    def around(cls, pivot_px: tuple[float, float], reach_px: float) -> PolarView:
        """Out to ``reach_px``, with a step of about a pixel at three quarters of that."""
        rows = max(int(reach_px), 4)
        columns = cv2.getOptimalDFTSize(int(np.clip(1.5 * np.pi * rows, 120, 1440)))
        return cls(pivot_px, rows, columns)

    @property
    def step_rad(self) -> float:
        """From one direction to the next."""
        return float(2.0 * np.pi / self.columns)

    @cached_property
    def radius_px(self) -> Array:
        """Of each row; (rows,)."""
        return np.asarray((np.arange(self.rows) + 0.5) * self.step_px)

    def of(
        self, picture: Single, angle_rad: float = 0.0, nearest: bool = False,
        outside: float = np.nan,
    ) -> Single:  # fmt: skip
        """A picture on the raster turned by an angle, and what lies ``outside`` of the picture;
        (rows, columns)."""
        x, y = self._places(angle_rad) if angle_rad else self._unturned
        how = cv2.INTER_NEAREST if nearest else cv2.INTER_LINEAR
        seen = cv2.remap(picture, x, y, how, borderMode=cv2.BORDER_CONSTANT, borderValue=outside)
        return np.asarray(seen, np.float32)

    @cached_property
    def _unturned(self) -> tuple[Single, Single]:
        return self._places(0.0)

    def _places(self, angle_rad: float) -> tuple[Single, Single]:
        """Column and row of a picture's pixel for each cell of the raster; (rows, columns) each."""
        phi = angle_rad + self.step_rad * np.arange(self.columns)
        radius = self.radius_px.astype(np.float32)[:, None]
        x = np.float32(self.pivot_px[0]) + radius * np.cos(phi).astype(np.float32)
        y = np.float32(self.pivot_px[1]) - radius * np.sin(phi).astype(np.float32)
        return x, y

    def angles(self) -> Array:
        """The angles [rad] (columns,) of ``gains``, from -pi."""
        return np.asarray(self.step_rad * (np.arange(self.columns) - self.columns // 2))

    def gains(self, frame: Single, behind: Single, part: Single, cover: Single) -> Array:
        """By how much ``part`` explains a frame better than ``behind`` does, per angle; (columns,).

        All on the raster; ``cover`` is 1 on the part. The sum over the part's area of the squared
        difference from what is behind, less that from the part. NaN is left out.
        """
        gains = Gains.of(self, frame[None], behind, rows_of(cover))
        return np.asarray(gains.by(part, cover)[0])


@dataclass(frozen=True)
class Gains:
    """Pictures and background on a raster, ready to be compared with parts at all angles.

    Their spectra are computed once, in single precision, of the ``rows`` in which the parts lie.
    """

    columns: int
    rows: slice
    weight: NDArray[np.complex64]
    square: NDArray[np.complex64]
    double: NDArray[np.complex64]

    @classmethod
    def of(
        cls, view: PolarView, seen: Single, behind: Single, rows: slice = slice(None)
    ) -> Gains:  # fmt: skip
        """Of pictures (pictures, rows, columns) over a background (rows, columns), both whole."""
        seen, behind = seen[:, rows], behind[rows]
        weight = np.empty(behind.shape, np.float32)
        square, double = np.empty(seen.shape, np.float32), np.empty(seen.shape, np.float32)
        _prepare(seen, behind, view.radius_px[rows].astype(np.float32), weight, square, double)
        return cls(view.columns, rows, _spectrum(weight), _spectrum(square), _spectrum(double))

    def by(self, part: Single, cover: Single) -> Array:
        """By how much a part (rows, columns) explains each picture better than the background does,
        at ``PolarView.angles``; (pictures, columns)."""
        part, cover = part[self.rows], cover[self.rows]
        inner = rows_of(cover)
        part, known = part[inner], np.isfinite(part[inner])
        on, picture = (np.where(known, one, np.float32(0)) for one in (cover[inner], part))
        total = np.einsum("nrk,rk->nk", self.square[:, inner], np.conj(_spectrum(on)))
        total += np.einsum("nrk,rk->nk", self.double[:, inner], np.conj(_spectrum(on * picture)))
        total -= (self.weight[inner] * np.conj(_spectrum(on * picture**2))).sum(0)
        gains = fft.irfft(total, self.columns, axis=-1, workers=most_threads())
        return np.roll(gains, self.columns // 2, axis=-1)


def grown_round(shape: Mask, cells: int) -> Mask:
    """A shape (rows, columns) with so many cells more about it, its columns going round.

    >>> grown_round(np.array([[1, 0, 0, 0], [0, 0, 0, 0]]) > 0, 1).astype(int).tolist()
    [[1, 1, 0, 1], [1, 0, 0, 0]]
    """
    beside = min(cells, shape.shape[1])
    wide = cv2.copyMakeBorder(shape.astype(np.uint8), 0, 0, beside, beside, cv2.BORDER_WRAP)
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    grown = cv2.dilate(wide, cross, iterations=cells)
    return np.asarray(grown[:, beside : beside + shape.shape[1]]) > 0


def rows_of(cover: Single) -> slice:
    """The rows of a shape (rows, columns) from the first to the last one that has any of it.

    >>> rows_of(np.array([[0, 0], [0, 1], [0, 0], [1, 0], [0, 0]], np.float32))
    slice(1, 4, None)
    """
    rows = np.flatnonzero(cover.any(1))
    return slice(int(rows[0]), int(rows[-1]) + 1) if rows.size else slice(0, 1)


@njit(cache=True, nogil=True)
def _prepare(seen, behind, radius, weight, square, double):  # type: ignore[no-untyped-def]
    """Fill what ``Gains`` has the spectra of: the weight of each cell, zero where not all is known;
    and what a part adds to the squares in each picture, where it is seen through and by its grey
    levels."""
    zero, two = np.float32(0.0), np.float32(2.0)
    for row in range(len(radius)):
        still, own = behind[row], weight[row]
        for column in range(still.size):
            own[column] = radius[row] if np.isfinite(still[column]) else zero
        for n in range(len(seen)):
            for column in range(still.size):
                own[column] = own[column] if np.isfinite(seen[n, row, column]) else zero
        for n in range(len(seen)):
            for column in range(still.size):
                known = own[column] > zero
                usual = still[column] if known else zero
                grey = seen[n, row, column] if known else zero
                square[n, row, column] = own[column] * usual * (usual - two * grey)
                double[n, row, column] = two * own[column] * grey


def _spectrum(values: Array | Single) -> NDArray[np.complex64]:
    return np.asarray(fft.rfft(np.asarray(values, np.float32), axis=-1, workers=most_threads()))
