"""The lattice of the layers' cells about the outline, and each cell's distance from it."""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Single
from servosight.tracking.appearance.surface import Surface
from servosight.tracking.fit import PolarGrid, spacing

PAD_PX = 14.0
"""Width of a soft shadow."""

_SPACING_PX = 1.0
_HUB = 0.35  # share of the radius within which there is little information


def wide(surface: Surface, shape: tuple[int, ...]) -> PolarGrid:
    """A lattice about the outline with room for edge and shadow, without the hub's far side."""
    old = surface.grid
    away = surface.outline_px - np.array(old.pivot_px)
    radius = np.hypot(*away.T)
    largest = float(radius.max())
    turned = np.mod(np.arctan2(-away[:, 1], away[:, 0]) - old.middle_rad + np.pi, 2 * np.pi) - np.pi
    span = turned[radius > _HUB * largest]
    pad = PAD_PX / (_HUB * largest)
    low, high = float(span.min()) - pad, float(span.max()) + pad
    last = min(largest + PAD_PX, float(np.hypot(shape[0], shape[1])))
    first = max(float(radius.min()) - PAD_PX, 4.0)
    space = spacing(_SPACING_PX, last)
    step = space / last
    return PolarGrid(
        old.pivot_px,
        first,
        space,
        old.middle_rad + low,
        step,
        int((last - first) / space) + 1,
        int(min(high - low, 2 * np.pi - 2 * step) / step) + 1,
        old.plane,
    )


def depth(surface: Surface, grid: PolarGrid) -> Single:
    """Distance of each cell from the outline [px], negative outside; (columns, rows)."""
    half = int(np.ceil(grid.largest_px)) + 4
    raster = np.zeros((2 * half + 1, 2 * half + 1), np.uint8)
    points = surface.outline_px - np.array(grid.pivot_px) + half
    cv2.fillPoly(raster, [np.round(points).astype(np.int32)], 1)
    within = cv2.distanceTransform(raster, cv2.DIST_L2, 5)
    without = cv2.distanceTransform(1 - raster, cv2.DIST_L2, 5)
    x, y = (p - c + half for p, c in zip(grid.points(0.0), grid.pivot_px, strict=True))
    return np.ascontiguousarray(
        cv2.remap(
            within - without,
            x.T.astype(np.float32),
            y.T.astype(np.float32),
            cv2.INTER_LINEAR,
            borderValue=-float(half),
        )
    )
