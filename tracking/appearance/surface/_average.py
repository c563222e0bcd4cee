"""The mean of frames turned back about a pivot."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy import ndimage

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.core import chunks, insert, middle_of, threaded, weights
from servosight.tracking.fit import GATE, PolarGrid

_ROOM_PX = 40  # about the surface, in which its pivot may move and its spline ends
_SPLINE_CELLS = 10  # beyond which a cell changes a spline by less than 1e-5 of its value


def spline_of(image: Image) -> Single:
    """Cubic spline coefficients of a picture, float32 (height, width)."""
    return np.asarray(ndimage.spline_filter(image, order=3, output=np.float32))


def swept(
    grid: PolarGrid, mask: Mask, angles_rad: Array, shape: tuple[int, ...]
) -> tuple[slice, slice]:
    """Rows and columns of a picture (height, width) in which the cells of a mask lie at some of
    the angles (n,), with room."""
    rows, columns = np.nonzero(mask & ~ndimage.binary_erosion(mask))  # none lies outside of these
    radius = grid.radius_px + grid.step_px * rows
    phi = grid.phi_rad + grid.step_rad * columns + angles_rad[:, None]
    places = grid.pivot_px[1] - radius * np.sin(phi), grid.pivot_px[0] + radius * np.cos(phi)
    low, high = (
        np.clip([int(reach(at)) + room for at in places], 0, shape)
        for reach, room in ((np.min, -_ROOM_PX), (np.max, _ROOM_PX))
    )
    return slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))


def average(
    splines: Single, angles_rad: Array, shifts_px: Array, grid: PolarGrid, wanted: Mask
) -> Single:
    """Spline coefficients of the mean of frames turned back, each shifted by its own.

    ``splines`` (frames, height, width) are the pictures'; of shape (columns, rows), float32. A
    cell's mean leaves out values far from its median, where something covered the surface for a
    time. Cells that are not ``wanted`` (columns, rows), nor near to one that is, are zero.
    """
    near = ndimage.binary_dilation(wanted, iterations=_SPLINE_CELLS)
    radius = grid.radius_px + grid.step_px * np.arange(grid.rows)
    phi = grid.phi_rad + grid.step_rad * np.arange(grid.columns) + angles_rad[:, None]
    centres = np.array(grid.pivot_px) + shifts_px
    mean = np.zeros((grid.columns, grid.rows))

    def part(columns: range) -> None:
        some = slice(columns.start, columns.stop)
        _usual_means(splines, centres, radius, phi[:, some], near[some], mean[some])

    threaded(part, chunks(grid.columns))
    filtered = ndimage.spline_filter(mean, order=3, mode="mirror", output=np.float64)
    return np.ascontiguousarray(filtered, dtype=np.float32)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _at(spline, x, y):  # type: ignore[no-untyped-def]
    """The value of a picture's spline; beyond the picture its border values are repeated."""
    height, width = spline.shape
    x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    column, row = int(x), int(y)
    a, b = weights(np.float32(x - column)), weights(np.float32(y - row))
    total = np.float32(0.0)
    for k in range(4):
        line = spline[min(max(row - 1 + k, 0), height - 1)]
        if 1 <= column < width - 2:
            c0, c1, c2, c3 = line[column - 1], line[column], line[column + 1], line[column + 2]
        else:
            c0, c1 = line[max(column - 1, 0)], line[column]
            c2, c3 = line[min(column + 1, width - 1)], line[min(column + 2, width - 1)]
        total += b[k] * (a[0] * c0 + a[1] * c1 + a[2] * c2 + a[3] * c3)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _usual_means(splines, centres, radius, phi, wanted, mean):  # type: ignore[no-untyped-def]
    """The mean of each wanted cell's values in the frames within the gate about their median.

    ``phi`` (frames, columns) are the cells' polar angles about the frames' ``centres``.
    """
    count, columns = phi.shape
    values = np.empty(count, np.float32)
    for m in range(columns):
        cos, sin = np.cos(phi[:, m]), np.sin(phi[:, m])
        for j in range(radius.size):
            if not wanted[m, j]:
                continue
            for i in range(count):
                x, y = centres[i, 0] + radius[j] * cos[i], centres[i, 1] - radius[j] * sin[i]
                insert(values, i, _at(splines[i], x, y))
            middle = middle_of(values)
            gate = GATE * 1.4826 * _median_away(values, middle) + 1.0
            total, used = 0.0, 0
            for i in range(count):
                if abs(values[i] - middle) <= gate:
                    total += values[i]
                    used += 1
            mean[m, j] = total / used


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
