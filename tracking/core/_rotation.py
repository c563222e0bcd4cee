"""Rotations in the picture, counter-clockwise positive as seen, with y pointing down."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from servosight.models.core import Array


def turning(angle_rad: ArrayLike) -> Array:
    """The rotation on x and y by each angle; (..., 2, 2)."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.moveaxis(np.array([[cos, sin], [-sin, cos]]), (0, 1), (-2, -1))


def turned(points_px: Array, pivot_px: tuple[float, float], angle_rad: float) -> Array:
    """Points (n, 2) as x, y turned about the pivot."""
    pivot = np.array(pivot_px)
    return np.asarray((points_px - pivot) @ turning(angle_rad).T + pivot)
