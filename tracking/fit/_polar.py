"""The moving part in polar coordinates about its pivot: a rotation is a shift along one axis.

Radius and polar angle of a picture's pixels do not depend on the surface, so the tables are
computed once and a turn of the surface is one subtraction; motion blur is a running mean along the
angle. Angles here are radians, counter-clockwise positive as seen (y points down).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import PICTURE, MotionPlane

NONE_STALE: Mask = np.empty(0, bool)
"""No pixel of a picture is left out as old."""

_BLOCK_PX = 32
_LARGE_PX, _WIDEST = 400.0, 2.0
_BAND_ROWS = 256


@dataclass(frozen=True)
class PolarGrid:
    """A lattice of ``rows`` radii by ``columns`` polar angles about ``pivot_px`` (x, y).

    It lies in the ``plane``, whose points are the picture's unless a camera off the axis or a lens
    makes a difference.
    """

    pivot_px: tuple[float, float]
    radius_px: float  # of row 0
    step_px: float
    phi_rad: float  # of column 0, with the surface at angle zero
    step_rad: float
    rows: int
    columns: int
    plane: MotionPlane = PICTURE

    @property
    def middle_rad(self) -> float:
        """Polar angle in the middle of the columns."""
        return self.phi_rad + 0.5 * (self.columns - 1) * self.step_rad

    @property
    def largest_px(self) -> float:
        """Radius of the last row."""
        return self.radius_px + (self.rows - 1) * self.step_px

    @property
    def lattice(self) -> tuple[float, float, float, float]:
        """What compiled passes take of it: the angle of column 0, columns per radian, the radius of
        row 0 and rows per pixel."""
        return self.phi_rad, 1 / self.step_rad, self.radius_px, 1 / self.step_px

    def points(self, angle_rad: Array | float) -> tuple[Array, Array]:
        """Where the lattice lies in the plane with the surface at ``angle_rad``: x, y [px].

        An angle for all, or one for each cell (rows, columns).
        """
        radius = self.radius_px + self.step_px * np.arange(self.rows)[:, None]
        phi = self.phi_rad + self.step_rad * np.arange(self.columns)[None, :] + angle_rad
        return self.pivot_px[0] + radius * np.cos(phi), self.pivot_px[1] - radius * np.sin(phi)

    def polar_of(self, shape: tuple[int, ...]) -> Iterator[tuple[slice, Array, Array]]:
        """Radius [px] and polar angle [rad] in the plane of the pixels of a picture of ``shape``
        (height, width): bands of its rows, and both there (rows, width).

        In bands, because all of a large picture at once takes a gigabyte.
        """
        x = np.arange(shape[1])
        for first in range(0, shape[0], _BAND_ROWS):
            rows = slice(first, min(first + _BAND_ROWS, shape[0]))
            y = np.arange(rows.start, rows.stop)
            place = np.column_stack([np.tile(x, y.size), np.repeat(y, x.size)]).astype(np.float64)
            place = self.plane.of_picture(place)
            dx, dy = place[:, 0] - self.pivot_px[0], self.pivot_px[1] - place[:, 1]
            band = y.size, x.size
            yield rows, np.hypot(dx, dy).reshape(band), np.arctan2(dy, dx).reshape(band)


def spacing(usual_px: float, largest_px: float) -> float:
    """The distance between a lattice's cells [px]: ``usual_px``, and more, up to twice as much, in
    a part that reaches beyond 400 px, so that it takes about as long as a smaller one.

    >>> spacing(0.8, 300.0), round(spacing(0.8, 600.0), 6)
    (0.8, 1.2)
    """
    return usual_px * float(np.clip(largest_px / _LARGE_PX, 1.0, _WIDEST))


@dataclass(frozen=True)
class Pixels:
    """A picture's pixels by rising polar angle about a pivot, twice round so that no slice wraps.

    ``index`` is the place in the flattened picture, ``block`` the number of the 8 x 8 px tile,
    ``delay`` the row's place in the readout, -1/2 (first) to 1/2 (last). ``farthest_px`` is the
    lattice's largest radius.
    """

    phi_rad: Array
    radius_px: Single
    index: NDArray[np.intp]
    block: NDArray[np.intp]
    delay: Single
    farthest_px: float

    @classmethod
    def about(
        cls,
        grid: PolarGrid,
        shape: tuple[int, ...],
        every: int = 1,
    ) -> Pixels:
        """The pixels of a picture of ``shape`` (height, width) within a lattice's largest radius.

        With ``every`` > 1 a regular thinning of them.
        """
        index, radius, phi = _within(grid, shape, every)
        order = np.argsort(phi, kind="stable")
        index, radius, phi = index[order], radius[order], phi[order]
        tiles = shape[1] // _BLOCK_PX + 1
        block = (index // shape[1] // _BLOCK_PX) * tiles + index % shape[1] // _BLOCK_PX
        delay = (index // shape[1] / max(shape[0] - 1, 1) - 0.5).astype(np.float32)
        return cls(
            np.concatenate([phi, phi + 2 * np.pi]),
            np.tile(radius, 2),
            np.tile(index, 2),
            np.tile(block, 2),
            np.tile(delay, 2),
            grid.largest_px,
        )

    @cached_property
    def outwards(self) -> Single:
        """The unit vectors away from the pivot, along x and against y; (2, pixels)."""
        return np.array([np.cos(self.phi_rad), np.sin(self.phi_rad)], np.float32)

    def at(self, places: NDArray[np.intp]) -> Pixels:
        """Those at some places of the table (pixels,), in that order."""
        return replace(
            self,
            phi_rad=self.phi_rad[places],
            radius_px=self.radius_px[places],
            index=self.index[places],
            block=self.block[places],
            delay=self.delay[places],
        )

    def covering(
        self, grid: PolarGrid, angle_rad: float, slack_rad: float = 0.0
    ) -> tuple[slice, float]:
        """The pixels that the turned lattice can reach, and the turn on this table's own circle.

        ``slack_rad`` is how far some may be turned from the rest.
        """
        half = min(0.5 * grid.columns * grid.step_rad + slack_rad, np.pi)
        lowest = grid.middle_rad + angle_rad - half
        start = np.mod(lowest, 2 * np.pi)
        first, last = np.searchsorted(self.phi_rad, [start, start + 2 * half])
        return slice(int(first), int(last)), angle_rad + float(start - lowest)


def _within(
    grid: PolarGrid, shape: tuple[int, ...], every: int
) -> tuple[NDArray[np.intp], Single, Array]:
    """One of ``every`` pixels of a picture within a lattice's largest radius: places in the
    flattened picture, radius, and polar angle from 0 to 2 pi."""
    found, seen = [], 0
    for rows, radius, phi in grid.polar_of(shape):
        near = np.flatnonzero(radius <= grid.largest_px)
        index = near[-seen % every :: every]
        seen += near.size
        distance = radius.ravel()[index].astype(np.float32)
        angle = np.mod(phi.ravel()[index], 2 * np.pi)
        found.append((index + rows.start * shape[1], distance, angle))
    index, distance, angle = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return index, distance, angle


@dataclass(frozen=True)
class Sample:
    """The model of the surface at the pixels it covers; all arrays (pixels,).

    ``chosen`` are those pixels' places in the table ``pixels``; ``value`` in grey levels;
    ``per_turn`` its change with the surface's own angle, per radian, and ``per_px`` with the
    pixel's radius. ``left_out`` counts covered pixels left out because they carry no new
    information.
    """

    pixels: Pixels
    chosen: NDArray[np.intp]
    value: Single
    per_turn: Single
    per_px: Single
    left_out: int = 0
