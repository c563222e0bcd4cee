"""The layers of some frames whose angles are roughly known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.appearance.layers._bundle import solve_layers, usual
from servosight.tracking.appearance.layers._information import informative
from servosight.tracking.appearance.layers._lattice import depth, wide
from servosight.tracking.appearance.layers._layers import Layers
from servosight.tracking.appearance.layers._problem import Bundle, FrameResidual
from servosight.tracking.appearance.surface import Surface
from servosight.tracking.core import Exposure

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
    used = informative(bundle, _INFORMATION_SHARE)
    cell = np.concatenate(
        [np.ravel_multi_index(r.frame.cell, used.shape)[r.trust > 0] for r in residuals]
    )
    level = np.concatenate([r.model[r.trust > 0] for r in residuals]).astype(np.float64)
    left = np.concatenate([(r.grey - r.model)[r.trust > 0] for r in residuals]).astype(np.float64)
    count = np.bincount(cell, minlength=used.size)
    misfit = np.bincount(cell, left**2, minlength=used.size) / np.maximum(count, 1)
    used[~usual(misfit.reshape(used.shape).astype(np.float32))] = 0
    telling = used.ravel()[cell] > 0
    left, level = left[telling], level[telling]
    return Layers(
        bundle.grid,
        np.ascontiguousarray(bundle.layers.transpose(1, 0, 2)),
        np.ascontiguousarray(used.T),
        bundle.bench,
        1.4826 * float(np.median(np.abs(left))),
        bundle.shot,
        float(np.corrcoef(level, level + left)[0, 1]),
    )
