"""The inverse of a spline's products and of its smoothing, for cells of equal weight.

Along the rows it is the spline's filter (Unser 1999), applied twice; along the columns a matrix of
five diagonals, factored once: for each wave along the columns it is what the squares of the
spline and of a second difference have.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from servosight.models.core import Array, Single
from servosight.tracking.core import chunks, threaded

_POLE = np.float32(np.sqrt(3.0) - 2.0)
# Added to what decays in zeros, where numbers too small for the usual form take a hundred times as
# long.
_FLOOR = np.float32(1e-25)
_REACH = 16  # cells, beyond which a power of the pole is below single precision


@dataclass(frozen=True)
class Preconditioner:
    """For layers (columns, rows, 2): ``scale`` (rows,) is applied before and after, ``size`` (2,)
    divides the layers' sides.

    ``factors`` (3, columns, rows) are the inverse diagonal of the columns' matrix, and the two
    diagonals of its lower factor.
    """

    scale: Single
    size: Single
    factors: Single

    @classmethod
    def of(
        cls, columns: int, scale: Single, size: tuple[float, float], finest: Array
    ) -> Preconditioner:
        """Spline's product and smoothing are equal where a second difference squared is ``finest``
        (rows,)."""
        factors = np.empty((3, columns, finest.size), np.float32)
        _factor(1.0 / finest, factors)
        return cls(np.asarray(scale, np.float32), np.array(size, np.float32), factors)

    def applied(self, layers: Single) -> Single:
        """The layers (columns, rows, 2) preconditioned."""
        once, twice = np.empty_like(layers), np.empty_like(layers)
        even = np.ones_like(self.scale)
        columns, rows = chunks(len(layers)), chunks(self.scale.size)
        threaded(lambda some: _filter(layers, self.scale, some.start, some.stop, once), columns)
        threaded(lambda some: _solve(self.factors, some.start, some.stop, once), rows)
        threaded(lambda some: _filter(once, even, some.start, some.stop, twice), columns)
        twice *= self.scale[:, None] / self.size
        return twice


@njit(cache=True, nogil=True, error_model="numpy")
def _factor(rough, factors):  # type: ignore[no-untyped-def]
    """Factor the square of the spline's matrix (1, 4, 1) / 6 along the columns, plus ``rough``
    times the square of a second difference; both repeat the end values."""
    columns, rows = factors.shape[1:]
    before, last, lower = np.ones(rows), np.ones(rows), np.zeros(rows)  # of the factor so far
    for n in range(columns):
        end = n == 0 or n == columns - 1
        one_end = n == 1 or n == columns - 1
        for j in range(rows):
            own = (26.0 if end else 18.0) / 36.0 + rough[j] * (2.0 if end else 6.0)
            next_to = (9.0 if one_end else 8.0) / 36.0 - rough[j] * (3.0 if one_end else 4.0)
            two = (1.0 / 36.0 + rough[j]) / before[j] if n > 1 else 0.0
            one = (next_to - two * before[j] * lower[j]) / last[j] if n > 0 else 0.0
            diagonal = own - one * one * last[j] - two * two * before[j]
            before[j], last[j], lower[j] = last[j], diagonal, one
            factors[0, n, j], factors[1, n, j], factors[2, n, j] = 1.0 / diagonal, one, two


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _solve(factors, start, stop, layers):  # type: ignore[no-untyped-def]
    """Solve for some rows of the layers in place, forwards and back along the columns."""
    columns = len(layers)
    inverse, one, two = factors[0], factors[1], factors[2]
    for n in range(1, columns):
        m = max(n - 2, 0)  # of the second column ``two`` is zero
        for j in range(start, stop):
            for side in range(2):
                own = layers[n, j, side] + _FLOOR - one[n, j] * layers[n - 1, j, side]
                layers[n, j, side] = own - two[n, j] * layers[m, j, side]
    for j in range(start, stop):
        for side in range(2):
            layers[columns - 1, j, side] *= inverse[columns - 1, j]
            own = layers[columns - 2, j, side] * inverse[columns - 2, j]
            own -= one[columns - 1, j] * layers[columns - 1, j, side]
            layers[columns - 2, j, side] = own
    for n in range(columns - 3, -1, -1):
        for j in range(start, stop):
            for side in range(2):
                own = layers[n, j, side] * inverse[n, j]
                own -= one[n + 1, j] * layers[n + 1, j, side]
                layers[n, j, side] = own - two[n + 2, j] * layers[n + 2, j, side]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _filter(layers, scale, start, stop, out):  # type: ignore[no-untyped-def]
    """The spline coefficients, along the rows, of both sides times ``scale`` in some columns;
    mirrored at the ends.

    Both sides in one pass: a side's next value waits for the one before.
    """
    rows = scale.size
    gain, ends = np.float32(6.0), _POLE / (_POLE * _POLE - np.float32(1.0))
    for n in range(start, stop):
        light = clear = np.float32(0.0)
        power = gain
        for k in range(_REACH):
            j = k % (2 * rows - 2)
            j = min(j, 2 * rows - 2 - j)
            light += power * scale[j] * layers[n, j, 0]
            clear += power * scale[j] * layers[n, j, 1]
            power *= _POLE
        out[n, 0, 0], out[n, 0, 1] = light, clear
        for j in range(1, rows):
            own = gain * scale[j]
            light = (own * layers[n, j, 0] + _FLOOR) + _POLE * light
            clear = (own * layers[n, j, 1] + _FLOOR) + _POLE * clear
            out[n, j, 0], out[n, j, 1] = light, clear
        light = ends * (light + _POLE * out[n, rows - 2, 0])
        clear = ends * (clear + _POLE * out[n, rows - 2, 1])
        out[n, rows - 1, 0], out[n, rows - 1, 1] = light, clear
        for j in range(rows - 2, -1, -1):
            light = _POLE * (light - out[n, j, 0])
            clear = _POLE * (clear - out[n, j, 1])
            out[n, j, 0], out[n, j, 1] = light, clear
