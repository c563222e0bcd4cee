"""The mean of frames turned back about a pivot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from scipy import ndimage

from servosight.models.core import Array, Image, Single
from servosight.tracking.core import chunks, insert, middle_of, threaded, weights
from servosight.tracking.fit import GATE, PolarGrid


def spline_of(image: Image) -> Single:
    """Cubic spline coefficients of a picture, float32 (height, width)."""
    return np.asarray(ndimage.spline_filter(image, order=3, output=np.float32))


def average(
    splines: Sequence[Single], angles_rad: Array, shifts_px: Array, grid: PolarGrid
) -> Single:
    """Spline coefficients of the mean of frames turned back, each shifted by its own.

    Of shape (columns, rows), float32. A cell's mean leaves out values far from its median, where
    something covered the surface for a time.
    """
    stack = np.empty((grid.columns, grid.rows, len(splines)), np.float32)
    radius = grid.radius_px + grid.step_px * np.arange(grid.rows)
    phi = grid.phi_rad + grid.step_rad * np.arange(grid.columns)

    def turn_back(number: int) -> None:
        centre = np.array(grid.pivot_px) + shifts_px[number]
        turned = phi + angles_rad[number]
        _turn_back(splines[number], centre, radius, turned, stack[:, :, number])

    threaded(turn_back, range(len(splines)))
    parts = threaded(lambda part: _usual_mean(stack[part.start : part.stop]), chunks(grid.columns))
    usual = np.concatenate(parts)
    mean = ndimage.spline_filter(usual, order=3, mode="mirror", output=np.float64)
    return np.ascontiguousarray(mean, dtype=np.float32)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _turn_back(spline, centre, radius, phi, out):  # type: ignore[no-untyped-def]
    """A picture's spline on a turned lattice; beyond the picture its border values are repeated."""
    height, width = spline.shape
    for m in range(phi.size):
        cos, sin = np.cos(phi[m]), np.sin(phi[m])
        for j in range(radius.size):
            x = min(max(centre[0] + radius[j] * cos, 0.0), width - 1.0)
            y = min(max(centre[1] - radius[j] * sin, 0.0), height - 1.0)
            column, row = int(x), int(y)
            a, b = weights(np.float32(x - column)), weights(np.float32(y - row))
            total = np.float32(0.0)
            for k in range(4):
                line = spline[min(max(row - 1 + k, 0), height - 1)]
                if 1 <= column < width - 2:
                    c0, c1 = line[column - 1], line[column]
                    c2, c3 = line[column + 1], line[column + 2]
                else:
                    c0, c1 = line[max(column - 1, 0)], line[column]
                    c2 = line[min(column + 1, width - 1)]
                    c3 = line[min(column + 2, width - 1)]
                total += b[k] * (a[0] * c0 + a[1] * c1 + a[2] * c2 + a[3] * c3)
            out[m, j] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _usual_mean(stack):  # type: ignore[no-untyped-def]
    """Mean over the last axis of the values within the gate about the median."""
    columns, rows, count = stack.shape
    mean = np.empty((columns, rows))
    values = np.empty(count, np.float32)
    for m in range(columns):
        for j in range(rows):
            for i in range(count):
                insert(values, i, stack[m, j, i])
            middle = middle_of(values)
            gate = GATE * 1.4826 * _median_away(values, middle) + 1.0
            total, used = 0.0, 0
            for i in range(count):
                if abs(values[i] - middle) <= gate:
                    total += values[i]
                    used += 1
            mean[m, j] = total / used
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def _median_away(values, middle):  # type: ignore[no-untyped-def]
    """The median distance of rising values from one of their middle: the nearest on either side
    of it are taken in turn, until half of them are."""
    low = values.size // 2 - 1
    high = low + 1
    before = last = np.float32(0.0)
    for _ in range(values.size // 2 + 1):
        before = last
        below = middle - values[low] if low >= 0 else np.float32(np.inf)
        above = values[high] - middle if high < values.size else np.float32(np.inf)
        if below < above:
            last = below
            low -= 1
        else:
            last = above
            high += 1
    return last if values.size % 2 else np.float32(0.5) * (before + last)
