"""The moving part in polar coordinates about its pivot: turning it is sliding it along one axis.

A picture's pixels keep their radius and their polar angle whatever the surface does, so the tables
are made once and a turn of the surface is one subtraction; motion blur is a running mean along the
angle. Inside, angles are radians, counter-clockwise positive as seen (y points down).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Mask = NDArray[np.bool_]

_BLOCK_PX = 8


@dataclass(frozen=True)
class Grid:
    """A lattice of ``rows`` radii by ``columns`` polar angles about ``pivot_px`` (x, y)."""

    pivot_px: tuple[float, float]
    radius_px: float  # of row 0
    step_px: float
    phi_rad: float  # of column 0, with the surface at angle zero
    step_rad: float
    rows: int
    columns: int

    @property
    def middle_rad(self) -> float:
        """Polar angle in the middle of the columns."""
        return self.phi_rad + 0.5 * (self.columns - 1) * self.step_rad

    @property
    def largest_px(self) -> float:
        """Radius of the last row."""
        return self.radius_px + (self.rows - 1) * self.step_px

    def points(self, angle_rad: float) -> tuple[Array, Array]:
        """Where the lattice lies in a picture with the surface at ``angle_rad``: x, y [px]."""
        radius = self.radius_px + self.step_px * np.arange(self.rows)[:, None]
        phi = self.phi_rad + self.step_rad * np.arange(self.columns)[None, :] + angle_rad
        return self.pivot_px[0] + radius * np.cos(phi), self.pivot_px[1] - radius * np.sin(phi)


@dataclass(frozen=True)
class Pixels:
    """A picture's pixels by rising polar angle about a pivot, twice round so that no slice wraps.

    ``index`` is the place in the flattened picture, ``block`` the number of the 8 x 8 px tile.
    """

    phi_rad: Array
    radius_px: Array
    index: NDArray[np.intp]
    block: NDArray[np.intp]

    @classmethod
    def about(
        cls,
        pivot_px: tuple[float, float],
        shape: tuple[int, ...],
        largest_px: float,
        every: int = 1,
    ) -> Pixels:
        """The pixels of a picture of ``shape`` (height, width) within ``largest_px`` of the pivot.

        With ``every`` > 1 a regular thinning of them.
        """
        y, x = np.indices(shape)
        dx, dy = x.ravel() - pivot_px[0], pivot_px[1] - y.ravel()
        radius = np.hypot(dx, dy)
        index = np.flatnonzero(radius <= largest_px)[::every]
        phi = np.mod(np.arctan2(dy[index], dx[index]), 2 * np.pi)
        order = np.argsort(phi, kind="stable")
        index, phi = index[order], phi[order]
        tiles = shape[1] // _BLOCK_PX + 1
        block = (index // shape[1] // _BLOCK_PX) * tiles + index % shape[1] // _BLOCK_PX
        return cls(
            np.concatenate([phi, phi + 2 * np.pi]),
            np.tile(radius[index], 2),
            np.tile(index, 2),
            np.tile(block, 2),
        )

    def covering(self, grid: Grid, angle_rad: float) -> tuple[slice, float]:
        """The pixels that the turned lattice can reach, and the turn on this table's own circle."""
        half = min(0.5 * grid.columns * grid.step_rad, np.pi)
        lowest = grid.middle_rad + angle_rad - half
        start = np.mod(lowest, 2 * np.pi)
        first, last = np.searchsorted(self.phi_rad, [start, start + 2 * half])
        return slice(int(first), int(last)), angle_rad + float(start - lowest)


@dataclass(frozen=True)
class Sample:
    """The surface's model at the pixels it covers; all arrays (pixels,).

    ``value`` in grey levels, ``per_rad`` its change with the pixel's polar angle, ``per_px`` with
    its radius.
    """

    index: NDArray[np.intp]
    block: NDArray[np.intp]
    phi_rad: Array
    radius_px: Array
    value: Array
    per_rad: Array
    per_px: Array

    @property
    def per_turn(self) -> Array:
        """Change with the surface's own angle [grey levels/rad]."""
        return -self.per_rad

    @property
    def per_shift(self) -> tuple[Array, Array]:
        """Change with a shift of the surface along x and along y [grey levels/px]."""
        cos, sin = np.cos(self.phi_rad), np.sin(self.phi_rad)
        along = self.per_rad / self.radius_px
        return along * sin - self.per_px * cos, along * cos + self.per_px * sin


def sample(
    grid: Grid, coefficients: Single, reach: Single, pixels: Pixels, angle_rad: float, smear: float
) -> Sample:
    """Evaluate the cubic spline of a surface turned to ``angle_rad`` at the picture's pixels.

    ``coefficients`` (rows, columns) are those of the spline, ``reach`` (rows, columns) the columns
    from a cell to the nearest one that is not the surface's; pixels nearer to it than half of
    ``smear`` (columns turned during the exposure) are left out.
    """
    part, turn = pixels.covering(grid, angle_rad)
    phi, radius = pixels.phi_rad[part], pixels.radius_px[part]
    place = (turn + grid.phi_rad, 1 / grid.step_rad, grid.radius_px, 1 / grid.step_px)
    chosen = np.empty(phi.size, np.intp)
    out = np.empty((3, phi.size))
    count = _spline(coefficients, reach, phi, radius, place, 0.5 * smear, chosen, out)
    chosen = chosen[:count]
    return Sample(
        pixels.index[part][chosen],
        pixels.block[part][chosen],
        phi[chosen],
        radius[chosen],
        out[0, :count],
        out[1, :count],
        out[2, :count],
    )


@njit(cache=True, error_model="numpy", fastmath=True)
def _spline(coefficients, reach, phi, radius, place, half, chosen, out):  # type: ignore[no-untyped-def]
    """Value and slopes at the pixels well inside; returns how many, their places in ``chosen``."""
    rows, columns = coefficients.shape
    origin, per_rad, first, per_px = place
    count = 0
    for i in range(phi.size):
        u = (phi[i] - origin) * per_rad
        v = (radius[i] - first) * per_px
        if u < 1.0 or v < 1.0 or u >= columns - 2 or v >= rows - 2:
            continue
        m, j = int(u), int(v)
        if reach[int(v + 0.5), int(u + 0.5)] <= half:
            continue
        a0, a1, a2, a3 = _weights(u - m)
        d0, d1, d2, d3 = _slopes(u - m)
        b0, b1, b2, b3 = _weights(v - j)
        e0, e1, e2, e3 = _slopes(v - j)
        # Along the rows first, with the value's and the slope's weights; then along the angle.
        total = by_u = by_v = 0.0
        for k, a, d in ((0, a0, d0), (1, a1, d1), (2, a2, d2), (3, a3, d3)):
            c0, c1 = coefficients[j - 1, m - 1 + k], coefficients[j, m - 1 + k]
            c2, c3 = coefficients[j + 1, m - 1 + k], coefficients[j + 2, m - 1 + k]
            across = b0 * c0 + b1 * c1 + b2 * c2 + b3 * c3
            total += a * across
            by_u += d * across
            by_v += a * (e0 * c0 + e1 * c1 + e2 * c2 + e3 * c3)
        chosen[count] = i
        out[0, count] = total
        out[1, count] = by_u * per_rad
        out[2, count] = by_v * per_px
        count += 1
    return count


@njit(cache=True, error_model="numpy", fastmath=True)
def _weights(t):  # type: ignore[no-untyped-def]
    """Cubic B-spline at the four nodes about a point ``t`` past the second."""
    w = 1.0 - t
    return (
        w * w * w / 6.0,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - w * w * (1.0 - 0.5 * w),
        t * t * t / 6.0,
    )


@njit(cache=True, error_model="numpy", fastmath=True)
def _slopes(t):  # type: ignore[no-untyped-def]
    w = 1.0 - t
    return -0.5 * w * w, t * (1.5 * t - 2.0), -w * (1.5 * w - 2.0), 0.5 * t * t


def smeared(coefficients: Single, smear: float) -> Single:
    """The spline of a surface that turned through ``smear`` columns during the exposure.

    A running mean over the stretch whose second moment is right also below one column: a box of
    width w over samples spreads by (w^2 - 1) / 12, so w = sqrt(1 + smear^2).
    """
    width = float(np.sqrt(1.0 + smear * smear))
    pad = int(width / 2) + 2
    total = np.cumsum(np.pad(coefficients, ((0, 0), (pad + 1, pad)), "edge"), 1, dtype=np.float64)
    columns = coefficients.shape[1]

    def up_to(offset: float) -> Array:
        whole = int(np.floor(offset))
        part = offset - whole
        start = pad + whole
        low = total[:, start : start + columns]
        high = total[:, start + 1 : start + 1 + columns]
        return (1.0 - part) * low + part * high

    mean = (up_to(0.5 + 0.5 * width) - up_to(0.5 - 0.5 * width)) / width
    return np.ascontiguousarray(mean, dtype=np.float32)
