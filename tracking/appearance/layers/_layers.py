"""Surface, transparency and background ("bench") as layers learnt from the video itself.

With the surface at an angle, a pixel p shows ``light(q) + clear(q) bench(p)``, with q the place on
the surface that turns to p: ``light`` is the surface's own, times its opacity, and ``clear`` the
transparency: 0 inside, 1 outside, between them at the edge and in the shadow that turns with the
surface. So edge and shadow contribute to the angle, too. All three are linear given the angles and
are found by alternating least squares over frames: per cell of the surface a line in the background
behind it, per pixel of the background a mean (the layers of Wang and Adelson 1994, with soft
masks).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import Exposure, slopes, smeared, weights
from servosight.tracking.fit import (
    ANGLE,
    NO_DIRECTIONS,
    NONE_STALE,
    PolarGrid,
    RingPixels,
    Rounds,
    Sample,
    runs_of,
    step,
    stretch,
    turned,
)

SEEN_THROUGH = 2
_ROOM = 2.0  # times the pixels that the cells in use cover
_ENOUGH = 300  # cells by which the share of a part in view is computed


@dataclass(frozen=True)
class Layers:
    """The learnt layers. ``coefficients`` (rows, columns, 2) of the splines of light and clearness.

    ``used`` (rows, columns) marks cells whose pixels hold information on the angle, by 2 where the
    background must be known for it; ``bench`` (height, width) is the background [grey levels], NaN
    where unknown; ``noise`` [grey levels] the rms residual of the layers in the frames that they
    were learnt from; its variance grows with the grey level g as ``1 + shot g``. ``correlation`` is
    that of picture and model.
    """

    grid: PolarGrid
    coefficients: Single
    used: NDArray[np.uint8]
    bench: Single
    noise: float
    shot: float
    correlation: float

    @cached_property
    def area_px(self) -> float:
        """Pixels that the cells in use cover."""
        radius = self.grid.radius_px + self.grid.step_px * np.arange(self.grid.rows)
        count = (self.used > 0).sum(1)
        return float((count * radius).sum() * self.grid.step_px * self.grid.step_rad)

    def in_view(self, angle_rad: float) -> float:
        """The share, by area, of the cells in use that lie in the picture at an angle.

        By position alone: a part before unknown background counts as in view.
        """
        phi, radius = self._informative
        x, y = self.grid.pivot_px
        turned = phi + angle_rad
        place = np.column_stack([x + radius * np.cos(turned), y - radius * np.sin(turned)])
        height, width = self.bench.shape
        column, row = self.grid.plane.to_picture(place).T
        inside = (np.abs(column + 0.5 - 0.5 * width) < 0.5 * width) & (
            np.abs(row + 0.5 - 0.5 * height) < 0.5 * height
        )
        return float(radius @ inside / radius.sum())

    @cached_property
    def _informative(self) -> tuple[Array, Array]:
        """Polar angle at angle zero [rad] and radius [px] of some cells in use; (cells,) each."""
        row, column = np.nonzero(self.used)
        every = 1 + row.size // _ENOUGH
        phi = self.grid.phi_rad + self.grid.step_rad * column[::every].astype(np.float64)
        return phi, self.grid.radius_px + self.grid.step_px * row[::every].astype(np.float64)

    @cached_property
    def _runs(self) -> NDArray[np.intp]:
        """Row, first and last column of the runs of cells in use; (runs, 3)."""
        return runs_of(self.used > 0)

    def smeared(self, columns: float) -> Layers:
        """The same layers with the motion blur of a turn by ``columns`` during the exposure."""
        by_column = np.ascontiguousarray(self.coefficients.transpose(1, 0, 2))
        flat = smeared(by_column.reshape(len(by_column), -1), columns).reshape(by_column.shape)
        spread = np.ones((1, 2 * int(np.ceil(0.5 * columns)) + 1), np.uint8)
        return replace(
            self,
            coefficients=np.ascontiguousarray(flat.transpose(1, 0, 2)),
            used=np.asarray(cv2.dilate(self.used, spread)),
        )

    def at(
        self, ring_pixels: RingPixels, angle_rad: float, exposure: Exposure,
        stale: Mask = NONE_STALE,
    ) -> Sample:  # fmt: skip
        """The model at the pixels with information on the angle, with the surface at an angle.

        The motion blur is in the layers already; pixels that are ``stale`` are left out.
        """
        chosen = np.empty(self._room(ring_pixels), np.intp)
        out = np.empty((3, chosen.size), np.float32)
        place = turned(self.grid.lattice, angle_rad, exposure.by_row)
        taken = self._compiled(ring_pixels, exposure, stale)
        count, left = _layered(*(*taken, place, chosen, out))
        value, per_turn, per_px = out[:, :count]
        return Sample(ring_pixels.pixels, chosen[:count], value, per_turn, per_px, left)

    def rounds(
        self, ring_pixels: RingPixels, exposure: Exposure, stale: Mask = NONE_STALE
    ) -> Rounds:
        """The steps of a fit of the angle to the pixels that ``at`` gives."""
        taken = self._compiled(ring_pixels, exposure, stale)
        model = (*taken, self.grid.lattice, self._room(ring_pixels))
        return Rounds(_rounds, model, ring_pixels.pixels)

    def _room(self, ring_pixels: RingPixels) -> int:
        """At most so many of the pixels hold information on the angle."""
        return min(int(_ROOM * self.area_px), ring_pixels.pixels.index.size // 2) + 1

    def _compiled(
        self, ring_pixels: RingPixels, exposure: Exposure, stale: Mask
    ) -> tuple[Any, ...]:
        """What compiled passes take, but for the lattice."""
        parts = (exposure.parts_rad / self.grid.step_rad).astype(np.float32)
        return (
            self.coefficients, self.used, self.bench.reshape(-1), self._runs, parts,
            exposure.by_row, *ring_pixels.compiled, stale,
        )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _rounds(  # type: ignore[no-untyped-def]
    coefficients, used, bench, runs, parts, motion, start, phi, radius, delay, index, stale,
    lattice, room, picture, state, aims, light,
):  # fmt: skip
    """As ``Rounds.loop``."""
    chosen = np.empty(room, np.intp)
    out = np.empty((3, room), np.float32)
    while True:
        count, left = _layered(
            coefficients, used, bench, runs, parts, motion, start, phi, radius, delay, index, stale,
            turned(lattice, state[ANGLE], motion), chosen, out,
        )  # fmt: skip
        goes_on, found = step(
            picture, index, radius, NO_DIRECTIONS, chosen[:count], out[:, :count], state, aims,
            light,
        )  # fmt: skip
        if not goes_on:
            return chosen[:count], out[:, :count], left, found


# Not all of fastmath: unknown background is NaN.
@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp", "reassoc", "nsz"})
def _layered(  # type: ignore[no-untyped-def]
    coefficients, used, bench, runs, parts, motion, start, phi, radius, delay, index, stale, place,
    chosen, out,
):  # fmt: skip
    """Value and slopes, means over equal stretches ``parts``, at the pixels that show cells in use
    and whose background is known if it is needed, but for stale ones; returns their number, their
    places in ``chosen``, and the number of stale ones."""
    rows, columns, _ = coefficients.shape
    flat = coefficients.reshape(-1)
    origin, per_rad, first, per_px = place
    share = np.float32(1.0 / parts.size)
    per_turn = -share * np.float32(per_rad)
    low, high = np.float32(1.0), np.float32(columns - 2.001)
    zero, half = np.float32(0.0), np.float32(0.5)
    one, stride = np.uint64(1), np.uint64(2 * columns)
    some = stale.size > 0
    count = left = 0
    for run in range(runs.shape[0]):
        ring = runs[run, 0]
        begin, end = stretch(runs[run], start, phi, place, motion)
        for here in range(begin, end):
            if count == chosen.size:
                break
            own = (motion[0] + motion[1] * delay[here]) * delay[here]
            u = np.float32((phi[here] - origin - own) * per_rad)
            v = np.float32((radius[here] - first) * per_px)
            if not ((v >= 1.0) & (v < rows - 2) & (u >= 1.0) & (u < columns - 2)):
                continue
            use = used[ring, np.int32(u + half)]
            # Opaque cells need no background.
            behind = bench[index[here]] if use == SEEN_THROUGH else zero
            if use == 0 or np.isnan(behind):
                continue
            if some and stale[index[here]]:
                left += 1
                continue
            j = np.int32(v)
            b, e = weights(v - np.float32(j)), slopes(v - np.float32(j))
            value = slope = outwards = zero
            for part in parts:
                column = min(max(u - part, low), high)
                m = np.int32(column)
                a, d = weights(column - np.float32(m)), slopes(column - np.float32(m))
                corner = np.uint64(2 * ((j - 1) * columns + m - 1))
                for n in range(4):
                    p0 = corner + np.uint64(2 * n)
                    p1, p2, p3 = p0 + stride, p0 + stride + stride, p0 + stride + stride + stride
                    c0, c1, c2, c3 = flat[p0], flat[p1], flat[p2], flat[p3]
                    if use == SEEN_THROUGH:
                        c0, c1 = c0 + behind * flat[p0 + one], c1 + behind * flat[p1 + one]
                        c2, c3 = c2 + behind * flat[p2 + one], c3 + behind * flat[p3 + one]
                    across = b[0] * c0 + b[1] * c1 + b[2] * c2 + b[3] * c3
                    outwards += a[n] * (e[0] * c0 + e[1] * c1 + e[2] * c2 + e[3] * c3)
                    value += a[n] * across
                    slope += d[n] * across
            chosen[count] = here
            out[0, count] = value * share
            out[1, count] = slope * per_turn
            out[2, count] = outwards * share * np.float32(per_px)
            count += 1
    return count, left
