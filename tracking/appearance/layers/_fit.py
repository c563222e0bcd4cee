"""The layers of some frames whose angles are roughly known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Image, Single
from servosight.tracking.appearance.layers._bundle import solve_layers, usual
from servosight.tracking.appearance.layers._lattice import depth, wide
from servosight.tracking.appearance.layers._layers import SEEN_THROUGH, Layers
from servosight.tracking.appearance.layers._problem import Bundle, FrameResidual
from servosight.tracking.appearance.surface import Surface
from servosight.tracking.core import Exposure
from servosight.tracking.fit import PolarGrid

_OPAQUE = 0.02
_INFORMATION_SHARE = 0.94  # share of the pixels' information that is used


def learn_layers(
    images: Sequence[Image],
    angles_rad: Array,
    exposures: Sequence[Exposure],
    light: Array,
    surface: Surface,
    noise: float,
) -> Layers:
    """Layers from frames with rough angles [rad] and the light's gain and offset (frames, 2).

    ``surface`` gives pivot and outline; ``exposures`` the motion during each frame; ``noise``
    [grey levels] is the frames', roughly.
    """
    grid = wide(surface, images[0].shape)
    inside_px = depth(surface, grid)
    clear = np.clip(0.5 - 0.5 * inside_px, 0.0, 1.0)
    start = Bundle(
        grid,
        np.stack([np.zeros_like(clear), clear], axis=2),
        angles_rad,
        light[:, 0],
        light[:, 1],
        noise=noise,
    )
    bundle, residuals = solve_layers(images, exposures, start, inside_px)
    return _judged(bundle, residuals)


def _judged(bundle: Bundle, residuals: Sequence[FrameResidual]) -> Layers:
    """The cells with information on the angle, and noise and correlation of the frames there."""
    grid, (light, clear) = bundle.grid, _values(bundle.layers)
    bench = bundle.bench[np.isfinite(bundle.bench)]
    mean, spread = (float(bench.mean()), float(bench.var())) if bench.size else (0.0, 0.0)
    used = _informative(light, clear, grid, mean, spread)
    cell = np.concatenate(
        [np.ravel_multi_index(r.frame.cell, used.shape)[r.trust > 0] for r in residuals]
    )
    level = np.concatenate([r.model[r.trust > 0] for r in residuals]).astype(np.float64)
    left = np.concatenate([(r.grey - r.model)[r.trust > 0] for r in residuals]).astype(np.float64)
    count = np.bincount(cell, minlength=used.size)
    misfit = np.bincount(cell, left**2, minlength=used.size) / np.maximum(count, 1)
    used[~usual(misfit.reshape(used.shape).astype(np.float32))] = 0
    informative = used.ravel()[cell] > 0
    left, level = left[informative], level[informative]
    return Layers(
        grid,
        np.ascontiguousarray(bundle.layers.transpose(1, 0, 2)),
        np.ascontiguousarray(used.T),
        bundle.bench,
        1.4826 * float(np.median(np.abs(left))),
        bundle.shot,
        float(np.corrcoef(level, level + left)[0, 1]),
    )


def _values(coefficients: Single) -> tuple[Single, Single]:
    """Light and transparency at the cells, (columns, rows) each, from their spline coefficients."""
    kernel = np.array([1.0, 4.0, 1.0]) / 6.0
    along = ndimage.correlate1d(coefficients, kernel, axis=0, mode="mirror")
    shown = ndimage.correlate1d(along, kernel, axis=1, mode="mirror")
    return np.ascontiguousarray(shown[:, :, 0]), np.ascontiguousarray(shown[:, :, 1])


def _informative(
    light: Single, clear: Single, grid: PolarGrid, mean: float, spread: float
) -> NDArray[np.uint8]:
    """The fewest cells that hold nearly all information on the angle; (columns, rows)."""
    slope = np.asarray(np.gradient(light + mean * clear, axis=0))
    through = np.gradient(clear, axis=0)
    radius = grid.radius_px + grid.step_px * np.arange(grid.rows)
    information = ndimage.uniform_filter((slope**2 + spread * through**2) * radius, 3)
    order = np.sort(information, axis=None)[::-1]
    total = np.cumsum(order)
    least = order[min(int(np.searchsorted(total, _INFORMATION_SHARE * total[-1])), order.size - 1)]
    through = np.where(ndimage.maximum_filter(clear, 3) > _OPAQUE, SEEN_THROUGH, 1)
    return np.ascontiguousarray(np.where(information >= least, through, 0).astype(np.uint8))
