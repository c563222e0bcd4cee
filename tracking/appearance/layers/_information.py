"""The cells of layers that hold the information on the angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Single
from servosight.tracking.appearance.layers._layers import SEEN_THROUGH
from servosight.tracking.appearance.layers._problem import Bundle

_OPAQUE = 0.02


def informative(bundle: Bundle, share: float) -> NDArray[np.uint8]:
    """The fewest cells that hold this share of all information on the angle; (columns, rows).

    1 where the surface is opaque, 2 where the background must be known for it, 0 elsewhere.
    """
    grid, (light, clear) = bundle.grid, _values(bundle.layers)
    bench = bundle.bench[np.isfinite(bundle.bench)]
    mean, spread = (float(bench.mean()), float(bench.var())) if bench.size else (0.0, 0.0)
    slope = np.asarray(np.gradient(light + mean * clear, axis=0))
    through = np.gradient(clear, axis=0)
    radius = grid.radius_px + grid.step_px * np.arange(grid.rows)
    information = ndimage.uniform_filter((slope**2 + spread * through**2) * radius, 3)
    order = np.sort(information, axis=None)[::-1]
    total = np.cumsum(order)
    least = order[min(int(np.searchsorted(total, share * total[-1])), order.size - 1)]
    through = np.where(ndimage.maximum_filter(clear, 3) > _OPAQUE, SEEN_THROUGH, 1)
    return np.ascontiguousarray(np.where(information >= least, through, 0).astype(np.uint8))


def _values(coefficients: Single) -> tuple[Single, Single]:
    """Light and transparency at the cells, (columns, rows) each, from their spline coefficients."""
    kernel = np.array([1.0, 4.0, 1.0]) / 6.0
    along = ndimage.correlate1d(coefficients, kernel, axis=0, mode="mirror")
    shown = ndimage.correlate1d(along, kernel, axis=1, mode="mirror")
    return np.ascontiguousarray(shown[:, :, 0]), np.ascontiguousarray(shown[:, :, 1])
