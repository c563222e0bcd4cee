"""Where the cells of the layers lie: about the outline, and in each frame, row by row."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from servosight.tracking.polar import Array, Grid, Mask, Single, weights
from servosight.tracking.shutter import Exposure
from servosight.tracking.surface import Surface

_PAD_PX = 14.0  # a soft shadow reaches so far
_HUB = 0.35  # nearer to the pivot than this share of the radius, little is told
_INSIDE_PX = 4.0  # this far inside the outline nothing shines through


def row_delay(shape: tuple[int, ...]) -> Array:
    """When each row is exposed, as a share of the readout about the middle row; (height,)."""
    return np.asarray(np.arange(shape[0]) / max(shape[0] - 1, 1) - 0.5)


def wide(surface: Surface, shape: tuple[int, ...]) -> Grid:
    """A lattice about the outline with room for its edge and shadow; the hub's back left out."""
    old = surface.grid
    away = surface.outline_px - np.array(old.pivot_px)
    radius = np.hypot(*away.T)
    largest = float(radius.max())
    turned = np.mod(np.arctan2(-away[:, 1], away[:, 0]) - old.middle_rad + np.pi, 2 * np.pi) - np.pi
    span = turned[radius > _HUB * largest]
    pad = _PAD_PX / (_HUB * largest)
    low, high = float(span.min()) - pad, float(span.max()) + pad
    last = min(largest + _PAD_PX, float(np.hypot(shape[0], shape[1])))
    first = max(float(radius.min()) - _PAD_PX, 4.0)
    step = old.step_px / last
    return Grid(
        old.pivot_px,
        first,
        old.step_px,
        old.middle_rad + low,
        step,
        int((last - first) / old.step_px) + 1,
        int(min(high - low, 2 * np.pi - 2 * step) / step) + 1,
        old.plane,
    )


def cover(surface: Surface, grid: Grid) -> tuple[Mask, Mask]:
    """Cells well inside the outline, and those within reach of its shadow; (columns, rows)."""
    half = int(np.ceil(grid.largest_px)) + 4
    raster = np.zeros((2 * half + 1, 2 * half + 1), np.uint8)
    points = surface.outline_px - np.array(grid.pivot_px) + half
    cv2.fillPoly(raster, [np.round(points).astype(np.int32)], 1)
    within = cv2.distanceTransform(raster, cv2.DIST_L2, 5)
    without = cv2.distanceTransform(1 - raster, cv2.DIST_L2, 5)
    x, y = grid.points(0.0)
    place = [(p - c + half).astype(np.float32) for p, c in zip((x, y), grid.pivot_px, strict=True)]
    inside, outside = (
        cv2.remap(d, place[0], place[1], cv2.INTER_LINEAR, borderValue=1e3).T
        for d in (within, without)
    )
    away = np.hypot(place[0] - half, place[1] - half).T
    beyond = away > half
    return (inside > _INSIDE_PX) & ~beyond, (outside < _PAD_PX) & ~beyond


def places(grid: Grid, angle_rad: float, exposure: Exposure, delay: Array) -> tuple[Single, Single]:
    """Where the cells lie in a frame, each in the row's own time; x and y, (columns, rows)."""
    x, y = _seen(grid, angle_rad)
    for _ in range(2 if exposure.slack_rad else 0):
        late = np.interp(y, np.arange(delay.size), delay)
        x, y = _seen(grid, angle_rad + exposure.per_delay_rad * late + exposure.bend_rad * late**2)
    return (np.ascontiguousarray(x.T, dtype=np.float32), np.ascontiguousarray(y.T, np.float32))


def _seen(grid: Grid, angle_rad: Array | float) -> tuple[Array, Array]:
    """Pixels x and y (rows, columns) of the lattice turned by an angle, or by one for each cell."""
    x, y = grid.points(angle_rad)
    pixels = grid.plane.to_picture(np.column_stack([x.ravel(), y.ravel()]))
    return pixels[:, 0].reshape(x.shape), pixels[:, 1].reshape(x.shape)


@njit(cache=True, nogil=True, error_model="numpy")
def _spline_at(spline, x, y, out):  # type: ignore[no-untyped-def]
    """A picture's spline at places; NaN outside of the picture."""
    height, width = spline.shape
    for m in range(x.shape[0]):
        for j in range(x.shape[1]):
            column, row = int(np.floor(x[m, j])), int(np.floor(y[m, j]))
            if column < 1 or row < 1 or column >= width - 2 or row >= height - 2:
                out[m, j] = np.nan
                continue
            a = weights(np.float32(x[m, j] - column))
            b = weights(np.float32(y[m, j] - row))
            total = np.float32(0.0)
            for k in range(4):
                line = spline[row - 1 + k]
                total += b[k] * (
                    a[0] * line[column - 1]
                    + a[1] * line[column]
                    + a[2] * line[column + 1]
                    + a[3] * line[column + 2]
                )
            out[m, j] = total


def look(spline: Single, place: tuple[Single, Single]) -> Single:
    """A picture's spline where the cells lie in it, NaN outside of it; (columns, rows)."""
    out = np.empty(place[0].shape, np.float32)
    _spline_at(spline, place[0], place[1], out)
    return out
