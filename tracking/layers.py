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
        box = _box(columns)
        blurred = ndimage.correlate1d(self.coefficients, box, axis=0, mode="nearest")
        spread = np.ones((2 * (box.size // 2) + 1, 1), np.uint8)
        used = self.used if box.size == 1 else cv2.dilate(self.used, spread)
        return replace(self, coefficients=blurred, used=np.asarray(used))

    def along_radius(self) -> Layers:
        """Layers that show, in place of grey levels, their change along the radius [1/px]."""
        slope = np.gradient(self.coefficients, self.grid.step_px, axis=1).astype(np.float32)
        return replace(self, coefficients=np.ascontiguousarray(slope))

    def at(self, pixels: Pixels, angle_rad: float, exposure: Exposure) -> Sample:
        """What the pixels show with the surface at an angle; the smear is the tables' own."""
        part, turn = pixels.covering(self.grid, angle_rad, exposure.slack_rad)
        grid = self.grid
        place = (turn + grid.phi_rad, 1 / grid.step_rad, grid.radius_px, 1 / grid.step_px)
        size = part.stop - part.start
        chosen, out = np.empty(size, np.intp), np.empty((2, size), np.float32)
        count = _layered(
            self.coefficients,
            self.used,
            self.bench.reshape(-1),
            pixels.phi_rad[part],
            pixels.radius_px[part],
            pixels.index[part],
            pixels.delay[part],
            place,
            (exposure.per_delay_rad, exposure.bend_rad),
            exposure.parts_rad,
            chosen,
            out,
        )
        chosen[:count] += part.start
        return Sample(pixels, chosen[:count], out[0, :count], out[1, :count], out[1, :0])


def _box(columns: float) -> Array:
    """A running mean's weights; for its width see ``polar.smeared``."""
    width = np.sqrt(1.0 + columns * columns)
    whole = int(np.ceil(0.5 * (width - 1.0)))
    edge = 0.5 * (width - 1.0) - (whole - 1)
    box = np.array([1.0] if whole == 0 else [edge, *np.ones(2 * whole - 1), edge])
    return np.asarray(box / width)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp", "reassoc", "nsz"})
def _layered(  # type: ignore[no-untyped-def]
    coefficients, used, bench, phi, radius, index, delay, place, motion, parts, chosen, out
):
    """Value and slope at the pixels that tell something; returns how many."""
    columns, rows, _ = coefficients.shape
    origin, per_rad, first, per_px = place
    share = np.float32(1.0 / parts.size)
    count = 0
    for i in range(phi.size):
        v = (radius[i] - first) * per_px
        if v < 1.0 or v >= rows - 2:
            continue
        own = motion[0] * delay[i] + motion[1] * delay[i] * delay[i]
        middle = (phi[i] - origin - own) * per_rad
        if middle < 1.0 or middle >= columns - 2:
            continue
        use, behind = used[int(middle + 0.5), int(v + 0.5)], bench[index[i]]
        if use == 0 or (use == SEEN_THROUGH and np.isnan(behind)):
            continue
        if np.isnan(behind):
            behind = np.float32(0.0)
        j = int(v)
        b = weights(np.float32(v - j))
        light = clear = light_by = clear_by = np.float32(0.0)
        for part in parts:
            u = min(max(middle - part * per_rad, 1.0), columns - 2.001)
            m = int(u)
            t = np.float32(u - m)
            a, d = weights(t), slopes(t)
            for k in range(4):
                c = coefficients[m - 1 + k]
                across = np.float32(0.0)
                through = np.float32(0.0)
                for n in range(4):
                    across += b[n] * c[j - 1 + n, 0]
                    through += b[n] * c[j - 1 + n, 1]
                light += a[k] * across
                clear += a[k] * through
                light_by += d[k] * across
                clear_by += d[k] * through
        chosen[count] = i
        out[0, count] = (light + clear * behind) * share
        out[1, count] = -(light_by + clear_by * behind) * share * per_rad
        count += 1
    return count
