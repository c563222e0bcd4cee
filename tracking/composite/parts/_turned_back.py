"""Pictures on a polar raster turned back by a part's turns, and what they leave of it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Mask, Single


def turned_back(seen: Single, turns: NDArray[np.intp]) -> Single:
    """Pictures (n, rows, columns), each turned back by its number of columns (n,).

    >>> turned_back(np.array([[[1, 2, 3, 4]]], np.float32), np.array([1])).tolist()
    [[[2.0, 3.0, 4.0, 1.0]]]
    """
    back = np.empty_like(seen)
    _turn_back(seen, turns % seen.shape[2], back)
    return back


def without_part(seen: Single, cover: Mask, turns: NDArray[np.intp]) -> Single:
    """Pictures (n, rows, columns) with NaN where the part, of shape ``cover`` (rows, columns) and
    turned by ``turns`` (n,) columns, lies."""
    left = np.empty_like(seen)
    _leave_out(seen, cover, turns % seen.shape[2], left)
    return left


def misfits(
    seen: Single, turns: NDArray[np.intp], part: Single, behind: Single
) -> tuple[Single, Single, Single]:
    """Of each cell of a part its mean squared difference from pictures (n, rows, columns) turned
    back by ``turns`` (n,) columns, that of what lies behind it there, NaN where nothing is known;
    and the share of the pictures in which it is known; (rows, columns) each."""
    own, against, share = (np.zeros(part.shape, np.float32) for _ in range(3))
    _add_misfits(seen, turns % seen.shape[2], part, behind, own, against, share)
    return own, against, share


@njit(cache=True, nogil=True)
def _turn_back(seen, turns, back):  # type: ignore[no-untyped-def]
    count, rows, columns = seen.shape
    for n in range(count):
        first = columns - turns[n]
        for row in range(rows):
            back[n, row, :first] = seen[n, row, turns[n] :]
            back[n, row, first:] = seen[n, row, : turns[n]]


@njit(cache=True, nogil=True)
def _leave_out(seen, on, turns, left):  # type: ignore[no-untyped-def]
    count, rows, columns = seen.shape
    nothing = np.float32(np.nan)
    for n in range(count):
        for row in range(rows):
            line, out, covered = seen[n, row], left[n, row], on[row]
            for column in range(turns[n]):
                out[column] = nothing if covered[column - turns[n] + columns] else line[column]
            for column in range(turns[n], columns):
                out[column] = nothing if covered[column - turns[n]] else line[column]


@njit(cache=True, nogil=True, error_model="numpy")
def _add_misfits(seen, turns, part, behind, own, against, share):  # type: ignore[no-untyped-def]
    count, rows, columns = seen.shape
    zero, one = np.float32(0.0), np.float32(1.0)
    fits, stays = np.empty(columns, np.float32), np.empty(columns, np.float32)
    line, still = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for row in range(rows):
        fits[:] = stays[:] = zero
        for n in range(count):
            first = columns - turns[n]
            line[:first], line[first:] = seen[n, row, turns[n] :], seen[n, row, : turns[n]]
            still[:first], still[first:] = behind[row, turns[n] :], behind[row, : turns[n]]
            for column in range(columns):
                apart = line[column] - part[row, column]
                moved = line[column] - still[column]
                known, told = np.isfinite(apart), np.isfinite(moved)
                own[row, column] += apart * apart if known else zero
                against[row, column] += moved * moved if told else zero
                fits[column] += one if known else zero
                stays[column] += one if told else zero
                share[row, column] += one if np.isfinite(line[column]) else zero
        for column in range(columns):
            own[row, column] /= fits[column]
            against[row, column] /= stays[column]
            share[row, column] /= count
