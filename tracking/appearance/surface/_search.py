"""Wide search for the angle: needs no start angle, and is not accurate to sub-pixels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.tracking.appearance.surface._surface import Surface
from servosight.tracking.fit import Pixels

# Motion of the outer part of the surface between two tries: less than a printed feature.
_STRIDE_PX = 1.6
_LEAST_PIXELS = 25
# A wide search evaluates all pixels at the tries that few of them find likely.
_FEW_OF = 8
_LIKELY = 40
_UNKNOWN = -1.0


def search(
    surface: Surface,
    pixels: Pixels,
    picture: NDArray[np.uint8],
    centre_rad: float,
    half_rad: float,
) -> tuple[float, float]:
    """The angle within ``centre_rad`` +- ``half_rad`` where surface and picture agree best.

    Returns it with its correlation; a thinned table of ``pixels`` is enough.

    """
    stride = _STRIDE_PX / surface.grid.largest_px
    count = int(half_rad / stride)
    tries = np.asarray(centre_rad + np.arange(-count, count + 1) * stride, dtype=np.float64)
    if tries.size > 2 * _LIKELY:
        few = scores(surface, pixels.at(np.arange(0, pixels.index.size, _FEW_OF)), picture, tries)
        # Too few of them in view say nothing.
        tries = tries[(few >= np.partition(few, -_LIKELY)[-_LIKELY]) | (few == _UNKNOWN)]
    found = scores(surface, pixels, picture, tries)
    best = int(np.argmax(found))
    return float(tries[best]), float(found[best])


def scores(
    surface: Surface, pixels: Pixels, picture: NDArray[np.uint8], angles_rad: Array
) -> Array:
    """Correlation of surface and picture at each of the angles (n,), ``_UNKNOWN`` where too little
    is in view.

    Between the surface's cells by straight lines: enough to find the angle.
    """
    grid = surface.grid
    place = (grid.phi_rad, 1 / grid.step_rad, grid.radius_px, 1 / grid.step_px)
    grey = picture.reshape(-1).take(pixels.index).astype(np.float32)
    found = np.empty(len(angles_rad))
    _correlations(
        surface.cells, surface.reach, pixels.phi_rad, pixels.radius_px, grey, place, angles_rad,
        found,
    )  # fmt: skip
    return found


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _correlations(  # type: ignore[no-untyped-def]
    cells, reach, phi, radius, grey, place, angles, out
):
    """Pearson's correlation at each angle, over the pixels that show cells inside the surface."""
    columns, rows = cells.shape
    low, per_rad, first, per_px = place
    half = min(0.5 * columns / per_rad, np.pi)
    middle = low + 0.5 * (columns - 1) / per_rad
    for n in range(angles.size):
        # Those within reach, on the table's own circle, which goes round twice.
        lowest = middle + angles[n] - half
        start = lowest - 2.0 * np.pi * np.floor(lowest / (2.0 * np.pi))
        origin = low + angles[n] + start - lowest
        begin, end = np.searchsorted(phi, start), np.searchsorted(phi, start + 2.0 * half)
        count = 0
        s = v = ss = vv = sv = 0.0
        for i in range(begin, end):
            x = np.float32((phi[i] - origin) * per_rad)
            y = np.float32((radius[i] - first) * per_px)
            if x < 0 or y < 0 or x >= columns - 1 or y >= rows - 1:
                continue
            m, j = np.int32(x), np.int32(y)
            p, q = x - np.float32(m), y - np.float32(j)
            if reach[m + (p > 0.5), j + (q > 0.5)] <= 0:
                continue
            one = cells[m, j] + q * (cells[m, j + 1] - cells[m, j])
            two = cells[m + 1, j] + q * (cells[m + 1, j + 1] - cells[m + 1, j])
            model = one + p * (two - one)
            seen = grey[i]
            count += 1
            s, v = s + seen, v + model
            ss, vv, sv = ss + seen * seen, vv + model * model, sv + seen * model
        power = (ss - s * s / count) * (vv - v * v / count) if count >= _LEAST_PIXELS else 0.0
        out[n] = (sv - s * v / count) / np.sqrt(power) if power > 0.0 else _UNKNOWN
