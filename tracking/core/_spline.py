"""Cubic B-splines on a lattice, and their motion blur."""

from __future__ import annotations

import numpy as np
from numba import njit

from servosight.models.core import Single


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def weights(t):  # type: ignore[no-untyped-def]
    """Cubic B-spline at the four nodes about a point ``t`` past the second; float32."""
    w = np.float32(1.0) - t
    half, sixth, most = np.float32(0.5), np.float32(1.0 / 6.0), np.float32(2.0 / 3.0)
    return (
        w * w * w * sixth,
        most - t * t * (np.float32(1.0) - half * t),
        most - w * w * (np.float32(1.0) - half * w),
        t * t * t * sixth,
    )


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def slopes(t):  # type: ignore[no-untyped-def]
    """Its derivative at the same four nodes; float32."""
    w = np.float32(1.0) - t
    half, two = np.float32(0.5), np.float32(2.0)
    more = np.float32(1.5)
    return -half * w * w, t * (more * t - two), -w * (more * w - two), half * t * t


def smeared(coefficients: Single, smear: float) -> Single:
    """The spline (columns, rows) of a surface that turned by ``smear`` columns while exposed.

    A running mean over the stretch whose second moment is right also below one column: a box of
    width w over samples spreads by (w^2 - 1) / 12, so w = sqrt(1 + smear^2).
    """
    return np.asarray(_running_mean(coefficients, np.sqrt(1.0 + smear * smear)))


@njit(cache=True, nogil=True, error_model="numpy")
def _running_mean(values, width):  # type: ignore[no-untyped-def]
    """Mean along the first axis over ``width`` samples about each; the end values are repeated."""
    columns, rows = values.shape
    whole = int(0.5 * (width - 1.0))  # full samples on either side, and a part of the next
    part = 0.5 * (width - 1.0) - whole
    last = columns - 1
    mean = np.empty_like(values)
    total = np.zeros(rows)
    for k in range(-whole, whole + 1):
        total += values[min(max(k, 0), last)]
    for column in range(columns):
        before = values[max(column - whole - 1, 0)]
        after = values[min(column + whole + 1, last)]
        leaving = values[max(column - whole, 0)]
        for row in range(rows):
            mean[column, row] = (total[row] + part * (before[row] + after[row])) / width
            total[row] += after[row] - np.float64(leaving[row])
    return mean
