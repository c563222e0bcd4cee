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
from scipy import ndimage

from servosight.tracking.polar import Array, Grid, Pixels, Sample, Single, slopes, weights
from servosight.tracking.shutter import Exposure

SEEN_THROUGH = 2
_MARGIN = 3  # columns that the surface may turn before its pixels are chosen anew


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
        box = box_of(columns)
        blurred = ndimage.correlate1d(self.coefficients, box, axis=0, mode="nearest")
        spread = np.ones((2 * (box.size // 2) + 1, 1), np.uint8)
        used = self.used if box.size == 1 else cv2.dilate(self.used, spread)
        return replace(self, coefficients=blurred, used=np.asarray(used))

    @cached_property
    def _wanted(self) -> NDArray[np.uint8]:
        """The cells in use with the columns beside them that a turn by the margin brings there."""
        return np.asarray(cv2.dilate(self.used, np.ones((2 * _MARGIN + 1, 1), np.uint8)))

    def about(self, pixels: Pixels, angle_rad: float, exposure: Exposure) -> Shown:
        """The model of the pixels that tell something with the surface about an angle."""
        chosen, where = covered(pixels, self.grid, angle_rad, exposure, self._wanted)
        behind = self.bench.reshape(-1).take(pixels.index.take(chosen))
        return Shown(self, pixels, angle_rad, exposure, chosen, where, behind)


@dataclass(frozen=True)
class Shown:
    """The layers at the pixels near to cells in use, for angles about ``angle_rad``.

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
        if abs(turned) > _MARGIN - 1:
            return layers.about(self.pixels, angle_rad, self.exposure).at(angle_rad)
        chosen, out = np.empty_like(self.chosen), np.empty((2, self.chosen.size), np.float32)
        count = _layered(
            layers.coefficients,
            layers.used,
            self.chosen,
            self.where,
            self.behind,
            np.float32(turned),
            np.float32(per_rad),
            (self.exposure.parts_rad * per_rad).astype(np.float32),
            chosen,
            out,
        )
        return Sample(self.pixels, chosen[:count], out[0, :count], out[1, :count], out[1, :0])


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


def box_of(columns: float) -> Array:
    """Weights of a running mean over ``columns``; for its width see ``polar.smeared``."""
    width = np.sqrt(1.0 + columns * columns)
    whole = int(np.ceil(0.5 * (width - 1.0)))
    edge = 0.5 * (width - 1.0) - (whole - 1)
    box = np.array([1.0] if whole == 0 else [edge, *np.ones(2 * whole - 1), edge])
    return np.asarray(box / width)


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


@_kernel
def _layered(  # type: ignore[no-untyped-def]
    coefficients, used, among, where, behind, turned, per_rad, parts, chosen, out
):
    """Value and slope at the pixels that tell something; returns how many."""
    columns, rows, _ = coefficients.shape
    flat = coefficients.reshape(-1)
    zero, share = np.float32(0.0), np.float32(1.0 / parts.size)
    low, high = np.float32(1.0), np.float32(columns - 2.001)
    count = 0
    for i in range(among.size):
        middle, v = where[0, i] - turned, where[1, i]
        if middle < low or middle > high:
            continue
        j = int(v)
        use, bench = used[int(middle + np.float32(0.5)), int(v + np.float32(0.5))], behind[i]
        if use == 0 or (use == SEEN_THROUGH and np.isnan(bench)):
            continue
        b0, b1, b2, b3 = weights(v - np.float32(j))
        light = clear = light_by = clear_by = zero
        for part in parts:
            u = min(max(middle - part, low), high)
            m = int(u)
            t = u - np.float32(m)
            a, d = weights(t), slopes(t)
            for k in range(4):
                start = 2 * ((m - 1 + k) * rows + j - 1)
                c = flat[start : start + 8]
                across = b0 * c[0] + b1 * c[2] + b2 * c[4] + b3 * c[6]
                light += a[k] * across
                light_by += d[k] * across
                if use == SEEN_THROUGH:
                    through = b0 * c[1] + b1 * c[3] + b2 * c[5] + b3 * c[7]
                    clear += a[k] * through
                    clear_by += d[k] * through
        if use == SEEN_THROUGH:
            light += clear * bench
            light_by += clear_by * bench
        chosen[count] = among[i]
        out[0, count] = light * share
        out[1, count] = -light_by * share * per_rad
        count += 1
    return count
