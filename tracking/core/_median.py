"""The median of what is known, for many places at once."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Image, Single
from servosight.tracking.core._parallel import chunks, threaded

_ABREAST = 64  # columns
_LARGE = 100_000  # values: fewer take less time than a thread to wake


def known_median(stack: Single | Image, least: int = 1) -> Single:
    """Median over the first axis without NaN (which numpy's own does slowly, with a warning).

    ``stack`` (n, ...) of grey levels; the result (...) is NaN where fewer than ``least`` of the n
    are known.

    >>> import numpy as np
    >>> known_median(np.array([[1, np.nan], [3, np.nan], [np.nan, 7]], np.float32)).tolist()
    [2.0, 7.0]
    """
    flat = np.ascontiguousarray(stack).reshape(len(stack), -1)
    median, pairs = np.empty(flat.shape[1], np.float32), _comparisons(len(flat))

    def chunk(columns: range) -> None:
        _medians(flat, pairs, least, median, columns.start, columns.stop)

    if flat.size < _LARGE:
        chunk(range(flat.shape[1]))
    else:
        threaded(chunk, chunks(flat.shape[1]))
    return median.reshape(stack.shape[1:])


@lru_cache(maxsize=256)
def _comparisons(count: int) -> NDArray[np.intp]:
    """The pairs (m, 2) of places whose values are put in order, one after the other, so that all
    ``count`` are: Batcher's merge exchange (Knuth, The Art of Computer Programming, 5.2.2 M)."""
    pairs: list[tuple[int, int]] = []
    length = 1
    while length < count:
        apart = length
        while apart:
            for first in range(apart % length, count - apart, 2 * apart):
                pairs += [
                    (low, low + apart)
                    for low in range(first, min(first + apart, count - apart))
                    if low // (2 * length) == (low + apart) // (2 * length)
                ]
            apart //= 2
        length *= 2
    return np.array(pairs, np.intp).reshape(-1, 2)


@njit(cache=True, nogil=True, error_model="numpy")
def _medians(stack, pairs, least, median, first, stop):  # type: ignore[no-untyped-def]
    """The median of the known values of columns from ``first`` up to ``stop``; many columns side by
    side, since the places to compare are the same for all."""
    count = len(stack)
    values = np.empty((count, _ABREAST), np.float32)
    known = np.empty(_ABREAST, np.intp)
    for start in range(first, stop, _ABREAST):
        width = min(_ABREAST, stop - start)
        known[:] = 0
        for n in range(count):
            for m in range(width):
                value = np.float32(stack[n, start + m])
                finite = np.isfinite(value)
                known[m] += finite
                values[n, m] = value if finite else np.float32(np.inf)
        for n in range(len(pairs)):
            low, high = values[pairs[n, 0]], values[pairs[n, 1]]
            for m in range(_ABREAST):
                one, other = low[m], high[m]
                low[m], high[m] = min(one, other), max(one, other)
        for m in range(width):
            last = max(known[m] - 1, 0)
            both = values[last // 2, m] + values[(last + 1) // 2, m]
            enough = known[m] >= max(least, 1)
            median[start + m] = np.float32(0.5) * both if enough else np.float32(np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def insert(values, count, value):  # type: ignore[no-untyped-def]
    """Put a value in its place among the first ``count``, which rise; fast for some dozens."""
    i = count
    while i > 0 and values[i - 1] > value:
        values[i] = values[i - 1]
        i -= 1
    values[i] = value


@njit(cache=True, nogil=True, error_model="numpy")
def middle_of(values):  # type: ignore[no-untyped-def]
    """The median of rising values."""
    half = values.size // 2
    if values.size % 2:
        return values[half]
    return np.float32(0.5) * (values[half - 1] + values[half])
