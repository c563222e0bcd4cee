"""Surface, cover and bench as layers, learnt from the video itself: edges and shadow tell too.

With the surface at an angle, a pixel p shows ``light(q) + clear(q) bench(p)``, with q the place on
the surface that turns to p: ``light`` is the surface's own, times its cover, and ``clear`` the
share of the bench that it lets through, 0 inside, 1 outside, between them at the edge and in the
shadow that goes with it. All three are linear given the angles, so they are found by
alternating least squares over frames: per cell of the surface a line in the bench behind it, per
pixel of the bench a mean (the layers of Wang and Adelson 1994, with soft masks).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.tracking.polar import Grid, Pixels, Sample, Single, slopes, smeared, weights
from servosight.tracking.shutter import Exposure

SEEN_THROUGH = 2
_MARGIN = 2.0  # columns that the surface may turn before its pixels are chosen anew


@dataclass(frozen=True)
class Layers:
    """The learnt layers. ``coefficients`` (columns, rows, 2) of the splines of light and clearness.

    ``used`` (columns, rows) marks cells whose pixels tell something of the angle, by 2 where the
    bench must be known for it; ``bench``
    (height, width) is what lies still [grey levels], NaN where unknown; ``noise`` [grey levels] the
    rms of what the layers leave unexplained in the frames that they were learnt from; its variance
    grows with the grey level g as ``1 + shot g``. ``correlation`` is that of picture and model.
    """

    grid: Grid
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
        return float(((self.used > 0) * radius).sum() * self.grid.step_px * self.grid.step_rad)

    def smeared(self, columns: float) -> Layers:
        """The same layers as a shutter shows them that is open while they turn by ``columns``."""
        flat = self.coefficients.reshape(len(self.coefficients), -1)
        blurred = smeared(flat, columns).reshape(self.coefficients.shape)
        spread = np.ones((2 * int(np.ceil(0.5 * columns)) + 1, 1), np.uint8)
        used = cv2.dilate(self.used, spread)
        return replace(self, coefficients=blurred, used=np.asarray(used))

    def about(self, pixels: Pixels, angle_rad: float, exposure: Exposure) -> Shown:
        """The model of the pixels that tell something with the surface about an angle."""
        chosen, where = covered(pixels, self.grid, angle_rad, exposure, self.used)
        behind = self.bench.reshape(-1).take(pixels.index.take(chosen))
        column, row = (where + np.float32(0.5)).astype(np.intp)
        # What nothing shines through needs no bench; where it is wanted it must be known.
        behind[self.used[column, row] != SEEN_THROUGH] = 0.0
        known = np.flatnonzero(np.isfinite(behind))
        return Shown(
            self,
            pixels,
            angle_rad,
            exposure,
            chosen.take(known),
            np.ascontiguousarray(where[:, known]),
            behind.take(known),
        )


@dataclass(frozen=True)
class Shown:
    """The layers at the pixels that show cells in use, for angles about ``angle_rad``.

    ``where`` (2, pixels) is the column and the row of the lattice that each of the ``chosen``
    pixels shows at that angle, ``behind`` (pixels,) the bench there.
    """

    layers: Layers
    pixels: Pixels
    angle_rad: float
    exposure: Exposure
    chosen: NDArray[np.intp]
    where: Single
    behind: Single

    def at(self, angle_rad: float) -> Sample:
        """What the pixels show with the surface at an angle; the smear is the tables' own."""
        layers = self.layers
        per_rad = 1.0 / layers.grid.step_rad
        turned = (angle_rad - self.angle_rad) * per_rad
        if abs(turned) > _MARGIN:
            return layers.about(self.pixels, angle_rad, self.exposure).at(angle_rad)
        out = np.empty((2, self.chosen.size), np.float32)
        parts = (self.exposure.parts_rad * per_rad).astype(np.float32)
        _layered(
            layers.coefficients,
            self.where,
            self.behind,
            np.float32(turned) + parts,
            np.float32(per_rad),
            out,
        )
        return Sample(self.pixels, self.chosen, out[0], out[1], out[1, :0])


def covered(
    pixels: Pixels,
    grid: Grid,
    angle_rad: float,
    exposure: Exposure,
    wanted: NDArray[np.uint8],
) -> tuple[NDArray[np.intp], Single]:
    """The pixels that show ``wanted`` cells (columns, rows) of a lattice turned by an angle.

    Their places in the table (pixels,), and the column and row that each shows (2, pixels).
    """
    part, turn = pixels.covering(grid, angle_rad, exposure.slack_rad)
    place = (turn + grid.phi_rad, 1 / grid.step_rad, grid.radius_px, 1 / grid.step_px)
    motion = exposure.per_delay_rad, exposure.bend_rad
    size = part.stop - part.start
    chosen = np.empty(size + 1, np.intp)
    where = np.empty((2, size + 1), np.float32)
    count = _select(
        wanted, pixels.phi_rad[part], pixels.radius_px[part], pixels.delay[part], place, motion,
        chosen, where,
    )  # fmt: skip
    return chosen[:count] + part.start, where[:, :count]


_kernel = njit(
    cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp", "reassoc", "nsz"}
)


@_kernel
def _select(wanted, phi, radius, delay, place, motion, chosen, where):  # type: ignore[no-untyped-def]
    """The pixels that show wanted cells, and the columns and rows they show; returns how many."""
    columns, rows = wanted.shape
    origin, per_rad, first, per_px = place
    count = 0
    for i in range(phi.size):
        v = (radius[i] - first) * per_px
        own = (motion[0] + motion[1] * delay[i]) * delay[i]
        u = (phi[i] - origin - own) * per_rad
        inside = (v >= 1.0) & (v < rows - 2) & (u >= 1.0) & (u < columns - 2)
        m = min(max(int(u + 0.5), 0), columns - 1)
        j = min(max(int(v + 0.5), 0), rows - 1)
        # Written always, kept or written over: a branch that cannot be foretold costs more.
        chosen[count] = i
        where[0, count], where[1, count] = u, v
        count += inside & (wanted[m, j] != 0)
    return count


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def before(flat, at, b, bench):  # type: ignore[no-untyped-def]
    """Light before a bench along four rows from a place in the flattened layers, weighed by ``b``.

    ``at`` is unsigned: a place that could be negative would be looked at twice.
    """
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    four, five, six, seven = np.uint64(4), np.uint64(5), np.uint64(6), np.uint64(7)
    light = b[0] * (flat[at] + bench * flat[at + one])
    light += b[1] * (flat[at + two] + bench * flat[at + three])
    light += b[2] * (flat[at + four] + bench * flat[at + five])
    return light + b[3] * (flat[at + six] + bench * flat[at + seven])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _layered(coefficients, where, behind, turned, per_rad, out):  # type: ignore[no-untyped-def]
    """Value and slope at the pixels, the mean over equal stretches ``turned`` by some columns."""
    columns, rows, _ = coefficients.shape
    flat = coefficients.reshape(-1)
    share = np.float32(1.0 / turned.size)
    low, high = np.float32(1.0), np.float32(columns - 2.001)
    stride = np.uint64(2 * rows)
    for i in range(behind.size):
        v, bench = where[1, i], behind[i]
        j = np.int32(v)
        b = weights(v - np.float32(j))
        value = slope = np.float32(0.0)
        for turn in turned:
            u = min(max(where[0, i] - turn, low), high)
            m = np.int32(u)
            a, d = weights(u - np.float32(m)), slopes(u - np.float32(m))
            at = np.uint64(2 * ((m - 1) * rows + j - 1))
            g0 = before(flat, at, b, bench)
            g1 = before(flat, at + stride, b, bench)
            g2 = before(flat, at + stride + stride, b, bench)
            g3 = before(flat, at + stride + stride + stride, b, bench)
            value += a[0] * g0 + a[1] * g1 + a[2] * g2 + a[3] * g3
            slope += d[0] * g0 + d[1] * g1 + d[2] * g2 + d[3] * g3
        out[0, i] = value * share
        out[1, i] = -slope * share * per_rad
