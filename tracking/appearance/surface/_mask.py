"""The cells that turn with the surface, as against those of the background, from known angles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.core import chunks, insert, known_median, middle_of, threaded
from servosight.tracking.fit import PolarGrid

_ROOM_CELLS = 40  # about the first mask: more than it grows by
_NEAR_ROWS, _ROOM_RAD = 16, 0.1  # beyond these rows a pixel's neighbours lie within that angle


def surface_mask(
    images: Sequence[Image], light: Single, angles_rad: Array, grid: PolarGrid, first: Mask
) -> Mask:
    """Cells that turn with the surface rather than stay with the background, about ``first``.

    ``light`` (frames,) makes the pictures as bright as each other.
    The background is the median of each pixel over frames in which surely nothing covers it. A cell
    is the surface's where the mean of frames turned back explains the frames better.
    """
    stack = np.stack(images)
    some = _columns_about(first)
    whole, grid = first, _columns_of(grid, some)
    mask = ndimage.binary_dilation(first[:, some], iterations=4)
    places = [
        tuple(p.astype(np.float32) for p in grid.points(float(angle))) for angle in angles_rad
    ]
    height, width = stack.shape[1:]
    seen = np.empty((len(stack), *mask.shape), np.float32)
    for one, own, image, (x, y) in zip(seen, light, stack, places, strict=True):
        one[:] = _resampled(own * image.astype(np.float32), (x, y))
        one[(x < 0) | (y < 0) | (x >= width) | (y >= height)] = np.nan
    noise = _temporal_noise(light[:, None, None] * stack[:, ::3, ::3])
    with np.errstate(invalid="ignore"):
        mean = known_median(seen)
        own = _nanmean((one - mean) ** 2 for one in seen)
    polar = np.empty((2, height, width), np.float32)
    for rows, radius, phi in grid.polar_of((height, width)):
        polar[0, rows] = phi - grid.phi_rad
        polar[1, rows] = (radius - grid.radius_px) / grid.step_px
    for _ in range(3):
        bench = _bench(stack, light, angles_rad, grid, polar, mask)
        against = _nanmean(
            (one - _resampled(bench, place)) ** 2 for one, place in zip(seen, places, strict=True)
        )
        own_near, against_near = _local(own), _local(against)
        # Where the background is never visible, the cell must at least look the same in all frames.
        never = np.isnan(against_near)
        contrast = _local((mean - _nan_to(_local(mean, 9), 0.0)) ** 2)
        turns = np.where(
            never,
            own_near < 4.0 * noise**2 + 0.25 * contrast + 4.0,
            own_near < 0.5 * against_near,
        )
        turns &= np.isfinite(own_near) & ndimage.binary_dilation(mask, iterations=2)
        mask_new = _largest(ndimage.binary_opening(turns, iterations=2), grid)
        if not mask_new.any():
            return np.zeros_like(whole)
        mask = ndimage.binary_dilation(mask_new, iterations=6)
    found = np.zeros_like(whole)
    found[:, some] = ndimage.binary_fill_holes(ndimage.binary_closing(mask_new, iterations=2))
    return found


def _columns_about(mask: Mask) -> slice:
    """The columns that a mask (rows, columns) covers, with room."""
    columns = np.flatnonzero(mask.any(0))
    if columns.size == 0:
        return slice(0, mask.shape[1])
    return slice(max(int(columns[0]) - _ROOM_CELLS, 0), int(columns[-1]) + 1 + _ROOM_CELLS)


def _columns_of(grid: PolarGrid, some: slice) -> PolarGrid:
    """These columns of a lattice alone."""
    first, last, _ = some.indices(grid.columns)
    phi_rad = grid.phi_rad + first * grid.step_rad
    return replace(grid, phi_rad=phi_rad, columns=last - first)


def _resampled(
    image: NDArray[np.float32], place: Sequence[NDArray[np.float32]]
) -> NDArray[np.float32]:
    return np.asarray(
        cv2.remap(image, place[0], place[1], cv2.INTER_LINEAR, borderValue=float("nan"))
    )


def _temporal_noise(stack: NDArray[np.float32]) -> float:
    """The camera's noise [grey levels]: most pixels change by it alone."""
    step = np.abs(np.diff(stack, axis=0))
    return float(1.4826 * np.median(step) / np.sqrt(2.0))


def _bench(
    stack: Image,
    light: Single,
    angles_rad: Array,
    grid: PolarGrid,
    polar: Single,
    mask: Mask,
) -> NDArray[np.float32]:
    """Median picture of the background, NaN where the (generous) mask always covers it, and where
    the turned lattice does not lie.

    ``polar`` are the column [rad] and the row of the lattice, at angle zero, of each pixel.
    """
    bench = np.empty(stack.shape[1:], np.float32)
    turns = np.asarray(angles_rad, np.float32)
    first = np.float32(turns.min() - _ROOM_RAD)
    width = np.float32(grid.columns * grid.step_rad + np.ptp(turns) + 2.0 * _ROOM_RAD)
    step_rad = np.float32(grid.step_rad)

    def part(rows: range) -> None:
        some = slice(rows.start, rows.stop)
        phi, row = polar[:, some]
        _median_uncovered(
            stack[:, some], light, turns, phi, row, step_rad, mask, first, width, bench[some]
        )

    threaded(part, chunks(len(bench)))
    return bench


@njit(cache=True, nogil=True, error_model="numpy")
def _median_uncovered(  # type: ignore[no-untyped-def]
    stack, light, angles, phi, row, step, mask, first, width, out
):
    """Each pixel's median over the pictures in which it shows no cell of the turned mask.

    NaN where it lies in none of them within the ``width`` [rad] from ``first`` on.
    """
    rows, columns = mask.shape
    circle, half = np.float32(2.0 * np.pi), np.float32(0.5)
    values = np.empty(len(stack), np.float32)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            j = np.int32(np.floor(row[y, x] + half))
            away = phi[y, x] - first
            away -= circle * np.floor(away / circle)
            if j > rows or (j > _NEAR_ROWS and away > width):
                out[y, x] = np.nan
                continue
            count = 0
            for n in range(len(stack)):
                turned = phi[y, x] - angles[n]
                turned -= circle * np.floor(turned / circle)
                m = np.int32(turned / step + half)
                if 0 <= j < rows and m < columns and mask[j, m]:
                    continue
                insert(values, count, light[n] * np.float32(stack[n, y, x]))
                count += 1
            out[y, x] = middle_of(values[:count]) if count else np.nan


def _nanmean(parts: Iterable[Single]) -> Single:
    """Mean of those of several arrays that are known; one at a time, as they are large."""
    total: Single = np.zeros((), np.float32)
    count: Single = np.zeros((), np.float32)
    for part in parts:
        known = np.isfinite(part)
        total = total + np.where(known, part, np.float32(0.0))
        count = count + known.astype(np.float32)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan), dtype=np.float32)


def _nan_to(values: NDArray[np.float32], fill: float) -> NDArray[np.float32]:
    return np.asarray(np.nan_to_num(values, nan=fill))


def _local(values: NDArray[np.float32], size: int = 5) -> NDArray[np.float32]:
    """Mean over a neighbourhood of the finite cells; NaN where there is none."""
    known = np.isfinite(values)
    total = ndimage.uniform_filter(np.where(known, values, 0.0), size, mode=("nearest", "wrap"))
    share = ndimage.uniform_filter(known.astype(np.float32), size, mode=("nearest", "wrap"))
    return np.asarray(np.where(share > 1e-3, total / np.maximum(share, 1e-3), np.nan), np.float32)


def _largest(mask: Mask, grid: PolarGrid) -> Mask:
    """The connected piece of largest area in the picture."""
    labels, count = ndimage.label(mask)
    if count == 0:
        return mask
    area = np.broadcast_to(np.arange(grid.rows)[:, None] + 1.0, mask.shape)
    sizes = ndimage.sum_labels(area, labels, np.arange(1, count + 1))
    return np.asarray(labels == 1 + int(np.argmax(sizes)))
