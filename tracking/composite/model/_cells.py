"""A part's cells in one picture: what is left of it beside the model, and by angle and shift.

Compiled, since every frame takes some of these passes over up to 20,000 cells.
"""

from __future__ import annotations

import numpy as np
from numba import njit

_HUBER = 1.5
_REJECTED, _REJECTED_STEP = 6.0, 12.0  # of the scale, and grey levels


@njit(cache=True, nogil=True, error_model="numpy")
def residuals(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, phi_rad, cover, level, slopes, angle_rad, shift_px
):
    """Picture less model (cells,), its slopes by angle and shift (3, cells), the cells' areas, and
    picture less background; cells outside the picture have no area.

    The pictures (height, width) are interpolated linearly; ``slopes`` (4, cells) are those of cover
    and level by angle, then by radius.
    """
    cells = radius_px.size
    height, width = picture.shape
    left, still, area = np.empty(cells), np.empty(cells), np.empty(cells)
    rows = np.empty((3, cells))
    for n in range(cells):
        radius = radius_px[n]
        cos, sin = np.cos(phi_rad[n] + angle_rad), np.sin(phi_rad[n] + angle_rad)
        x = pivot_px[0] + radius * cos + shift_px[0]
        y = pivot_px[1] - radius * sin + shift_px[1]
        area[n] = radius if 0.0 <= x <= width - 1.0 and 0.0 <= y <= height - 1.0 else 0.0
        x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
        column, row = min(int(x), width - 2), min(int(y), height - 2)
        fx, fy = x - column, y - row
        a, b = (1.0 - fx) * (1.0 - fy), fx * (1.0 - fy)
        c, d = (1.0 - fx) * fy, fx * fy
        seen = a * picture[row, column] + b * picture[row, column + 1]
        seen += c * picture[row + 1, column] + d * picture[row + 1, column + 1]
        back = a * behind[row, column] + b * behind[row, column + 1]
        back += c * behind[row + 1, column] + d * behind[row + 1, column + 1]
        by_phi = slopes[1, n] - slopes[0, n] * back
        by_radius = slopes[3, n] - slopes[2, n] * back
        around = by_phi / max(radius, 1.0)
        rows[0, n] = by_phi
        rows[1, n] = cos * by_radius - sin * around
        rows[2, n] = -sin * by_radius - cos * around
        left[n] = seen - (1.0 - cover[n]) * back - level[n]
        still[n] = seen - back
    return left, rows, area, still


@njit(cache=True, nogil=True, error_model="numpy")
def normal_equation(left, rows, area, scale, unknowns):  # type: ignore[no-untyped-def]
    """Weights (cells,) of the residuals by Huber, zero where they are far too large for ``scale``;
    the normal matrix (unknowns, unknowns) and its right side (unknowns,)."""
    weight = np.empty(left.size)
    matrix, side = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    for n in range(left.size):
        away = abs(left[n])
        own = area[n] / max(1.0, away / (_HUBER * scale))
        if away >= _REJECTED * scale + _REJECTED_STEP:
            own = 0.0
        weight[n] = own
        for i in range(unknowns):
            term = own * rows[i, n]
            side[i] += term * left[n]
            for j in range(i + 1):
                matrix[i, j] += term * rows[j, n]
    for i in range(unknowns):
        for j in range(i):
            matrix[j, i] = matrix[i, j]
    return weight, matrix, side
