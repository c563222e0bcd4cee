"""A part's picture and shape on a raster about its pivot, over the background; and its blur.

A part that turns while it is exposed is seen as the mean of itself at the angles it passes: on the
raster, a running mean along the directions of the cover, and of the grey level times the cover.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numba import njit
from scipy import ndimage

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import Index, known_median, threaded
from servosight.tracking.verification import PolarView, grown_round

_GROW = 3  # cells
_EDGE_PX = 1.0
_BESIDE = 5  # cells: a shadow
_MATTED, _LEAST_NOISE, _COVER_SIGMA = 3, 1.0, 0.3


@dataclass(frozen=True)
class PartRaster:
    """A part at angle zero on the raster ``view``; (rows, columns) each.

    ``cover`` from 0 to 1, ``level`` its grey level times that; ``near`` marks the cells that
    are compared with pictures. ``behind`` (height, width) is the background's picture, ``grain``
    how many pixels along a side share one sample.
    """

    view: PolarView
    cover: Single
    level: Single
    near: Mask
    behind: Single
    grain: int = 1

    @classmethod
    def of(
        cls, pictures: Single, angle_rad: Array, pivot_px: tuple[float, float],
        cover: Single, view: PolarView, usual: Single | None = None, grain: int = 1,
    ) -> PartRaster:  # fmt: skip
        """From pictures (n, height, width) at known angles, and the part's shape on a raster.

        ``view`` is the raster about ``pivot_px`` in these pictures, ``cover`` 1 on the part,
        ``usual`` (height, width) the pictures' median if it is known, ``grain`` how many pixels
        along a side share one sample.
        """
        tiled = cv2.GaussianBlur(np.tile(cover, (1, 3)), (0, 0), _EDGE_PX)
        soft = np.asarray(tiled[:, view.columns : 2 * view.columns], np.float32)
        near = grown_round(cover > 0.5, _GROW)
        usual = known_median(pictures) if usual is None else usual
        behind = _background(pictures, angle_rad, view, near, usual)
        level, shown = _levels(pictures, angle_rad, view, soft, near, behind)
        whole = np.asarray(np.where(np.isfinite(behind), behind, usual), np.float32)
        return cls(view, soft, level, near & shown, whole, grain)

    def blurred(self, turn_rad: float) -> PartRaster:
        """As seen while the part turns by an angle."""
        columns = turn_rad / self.view.step_rad
        cover, level = (_running_mean(field, columns) for field in (self.cover, self.level))
        return replace(self, cover=cover, level=level)

    def matted(self, pictures: Single, angle_rad: Array) -> PartRaster:
        """With the cover of each cell as pictures (n, height, width) at angles (n,) show it.

        A cell that the part covers by a share c shows ``level + (1 - c) behind``: two numbers, by
        least squares over pictures in which what is behind differs. What a shape that is a pixel
        too wide counts as the part, and a shadow, are so transparent as they are.
        """
        near = grown_round(self.near, _BESIDE)
        rows, columns = np.nonzero(near)
        seen, still = _seen(pictures, angle_rad, self.view, (rows, columns), self.behind)
        shown = (np.isfinite(seen) & np.isfinite(still)).any(0)
        near[rows[~shown], columns[~shown]] = False
        cells = rows[shown], columns[shown]
        cover, level = self.cover.copy(), self.level.copy()
        cover[cells], level[cells] = _shares(
            seen[:, shown], still[:, shown], cover[cells], level[cells]
        )
        return replace(self, cover=cover, level=level, near=near)

    def reached(self, turn_rad: float) -> Mask:
        """The cells near the part while it turns by an angle about its own."""
        half = int(np.ceil(0.5 * turn_rad / self.view.step_rad))
        near = self.near.astype(np.uint8)
        wide = ndimage.maximum_filter1d(near, 2 * half + 1, axis=1, mode="wrap")
        return np.asarray(wide > 0)


def _running_mean(values: Single, columns: float) -> Single:
    """The mean over some columns, a fraction of one included, about each of them; (rows, columns).

    The integral along the row, interpolated linearly half of them before and behind.
    """
    if columns < 1e-6:
        return values
    mean = np.empty(values.shape, np.float32)
    _means(np.ascontiguousarray(values, np.float32), columns, mean)
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def _means(values, columns, mean):  # type: ignore[no-untyped-def]
    """Each row's means over some columns, from its integral up to each column's end."""
    count = values.shape[1]
    beyond = int(np.ceil(0.5 * columns)) + 1
    total = np.empty(count + 2 * beyond + 1)  # up to a column's end
    after, before = beyond + 0.5 + 0.5 * columns, beyond + 0.5 - 0.5 * columns
    up, low = int(np.floor(after)), int(np.floor(before))
    p, q = after - up, before - low
    for row in range(len(values)):
        so_far, at = 0.0, (-beyond - 1) % count
        for n in range(total.size):
            so_far += values[row, at]
            total[n] = so_far
            at = at + 1 if at < count - 1 else 0
        for n in range(count):
            end = (1.0 - p) * total[n + up] + p * total[n + up + 1]
            start = (1.0 - q) * total[n + low] + q * total[n + low + 1]
            mean[row, n] = (end - start) / columns


def cover_in(view: PolarView, near: Mask, angle_rad: float, shape: tuple[int, ...]) -> Mask:
    """A shape on the raster as pixels of a picture (height, width), turned by an angle."""
    return next(covers_in(view, near, [angle_rad], shape))


def covers_in(
    view: PolarView, near: Mask, angles_rad: Iterable[float], shape: tuple[int, ...]
) -> Iterator[Mask]:
    """As ``cover_in``, at each of the angles."""
    rows = np.flatnonzero(near.any(1))
    reached = int(rows[-1]) + 1 if rows.size else 0
    y, x = np.indices(shape, dtype=np.float32)
    dx, dy = x - np.float32(view.pivot_px[0]), np.float32(view.pivot_px[1]) - y
    row = np.rint(np.hypot(dx, dy) / view.step_px - 0.5).astype(np.intp)
    pixels = np.flatnonzero(row < reached)
    start = np.maximum(row.ravel()[pixels], 0) * view.columns
    column = np.arctan2(dy.ravel()[pixels], dx.ravel()[pixels]) / view.step_rad
    for angle in angles_rad:
        turned = np.rint(column - angle / view.step_rad).astype(np.intp) % view.columns
        cover = np.zeros(shape, bool)
        cover.ravel()[pixels] = near.ravel()[start + turned]
        yield cover


def _levels(
    pictures: Single, angle_rad: Array, view: PolarView, soft: Single, near: Mask, behind: Single
) -> tuple[Single, Mask]:
    """The part's grey levels times its cover ``soft``, and where it is shown at all; (rows,
    columns) each, zero away from the cells ``near`` it and their neighbours, on which slopes
    depend."""
    rows, columns = np.nonzero(grown_round(near, 1))
    seen, still = _seen(pictures, angle_rad, view, (rows, columns), behind)
    clear = 1.0 - soft[rows, columns]
    left = seen - clear * np.where(np.isfinite(still), still, seen)
    level, shown = np.zeros(near.shape, np.float32), np.zeros(near.shape, bool)
    level[rows, columns] = np.nan_to_num(known_median(left))
    shown[rows, columns] = np.isfinite(seen).any(0)
    return level, shown


def _seen(
    pictures: Single, angle_rad: Array, view: PolarView, cells: tuple[Index, Index], behind: Single
) -> tuple[Single, Single]:
    """What pictures (n, height, width) at angles (n,) and the background show at cells of the
    raster, given by row and column; (n, cells) each, NaN beyond the pictures."""
    radius, phi = view.radius_px[cells[0]], view.step_rad * cells[1]
    places = np.stack([radius * np.cos(phi), radius * np.sin(phi)])
    seen = np.empty((len(pictures), phi.size), np.float32)
    still = np.empty_like(seen)
    behind = np.ascontiguousarray(behind, np.float32)

    def look(number: int) -> None:
        picture = np.ascontiguousarray(pictures[number], np.float32)
        _look(picture, behind, view.pivot_px, places, angle_rad[number], seen[number],
              still[number])  # fmt: skip

    threaded(look, range(len(pictures)))
    return seen, still


@njit(cache=True, nogil=True, error_model="numpy")
def _look(picture, behind, pivot_px, places_px, angle_rad, seen, still):  # type: ignore[no-untyped-def]
    """Fill in what a picture and the background (height, width) show at places (2, n) right of a
    pivot and above it, turned about it by an angle; interpolated linearly, NaN beyond the picture.
    """
    height, width = picture.shape
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    for n in range(seen.size):
        x = pivot_px[0] + cos * places_px[0, n] - sin * places_px[1, n]
        y = pivot_px[1] - sin * places_px[0, n] - cos * places_px[1, n]
        if not (0.0 <= x <= width - 1.0 and 0.0 <= y <= height - 1.0):
            seen[n] = still[n] = np.nan
            continue
        column, row = min(int(x), width - 2), min(int(y), height - 2)
        right, down = x - column, y - row
        for image, shown in ((picture, seen), (behind, still)):
            upper = (1.0 - right) * image[row, column] + right * image[row, column + 1]
            lower = (1.0 - right) * image[row + 1, column] + right * image[row + 1, column + 1]
            shown[n] = (1.0 - down) * upper + down * lower


def _shares(seen: Single, still: Single, cover: Single, level: Single) -> tuple[Single, Single]:
    """Cover and level (cells,) of cells that show ``seen`` (n, cells) over ``still`` (n, cells),
    from a cover and level known before."""
    known = np.isfinite(seen) & np.isfinite(still)
    seen, still = (np.where(known, field, 0.0) for field in (seen, still))
    for _ in range(_MATTED):
        left = np.abs(seen - level - (1.0 - cover) * still)
        usual = np.maximum(1.4826 * known_median(np.where(known, left, np.nan)), _LEAST_NOISE)
        weight = known / np.maximum(left / usual, 1.0)
        total = np.maximum(weight.sum(0), 1e-9)
        mean = [(weight * field).sum(0) / total for field in (seen, still)]
        apart = still - mean[1]
        held = (usual / _COVER_SIGMA) ** 2
        clear = ((weight * apart * (seen - mean[0])).sum(0) + held * (1.0 - cover)) / (
            (weight * apart**2).sum(0) + held
        )
        cover = np.clip(1.0 - clear, 0.0, 1.0)
        level = mean[0] - (1.0 - cover) * mean[1]
    return cover, level


def _background(
    pictures: Single, angle_rad: Array, view: PolarView, near: Mask, usual: Single
) -> Single:
    """Median of the pictures where the part is not, ``usual`` where it never is; NaN where it
    always is."""
    covers = np.stack(list(covers_in(view, near, angle_rad.tolist(), pictures.shape[1:])))
    swept = covers.any(0)
    behind = usual.copy()
    behind[swept] = known_median(np.where(covers[:, swept], np.float32(np.nan), pictures[:, swept]))
    return behind
