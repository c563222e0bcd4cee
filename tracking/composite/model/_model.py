"""Background and turning part as one model of a picture, and the fit of its angle.

The part is a set of cells about the pivot, each with a grey level and a cover between 0 and 1; what
it does not cover is the background. A plain bar is located by its edges against that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.composite.model._cells import pose_of, residuals, squares_of, weights_of
from servosight.tracking.composite.model._raster import PartRaster
from servosight.tracking.core import Index, threaded, turning
from servosight.tracking.verification import PolarView

_COMMON_PX = 0.1
_CORRELATED_PX2 = 20.0  # of residuals
_BLOCK_PX = 8  # along a side: a block of the codec, over which residuals are correlated
_MOST_CELLS = 20_000
_LEAST_EXPLAINED, _LEAST_KEPT = 0.3, 0.35


@dataclass(frozen=True)
class PoseFit:
    """Angle [rad] and shift [px] of the part in one picture.

    ``sigma_rad`` as for residuals that are correlated over the model's blocks; ``kept`` is the
    share of cells that the model explains, ``explained`` how much better it does than the
    background alone, 0 to 1; ``covariance`` that of angle and shift (3, 3). ``sides_rad`` is the
    angle by the leading half of the cells less that by the trailing one. A shift by one pixel,
    as of a pivot that is off, is taken for ``per_px_rad`` at most: much of an arm, hardly anything
    of a wheel. ``per_left_rad`` is the turn that would leave as much as the background alone does,
    ``row_px`` the mean row of what determines the angle; ``gain`` by how much less is left than by
    the background alone [grey levels^2 px] for each pixel of a ring's width.
    """

    angle_rad: float
    shift_px: Array
    covariance: Array
    kept: float
    explained: float
    noise: float
    sides_rad: float
    per_px_rad: float
    per_left_rad: float
    row_px: float
    gain: float

    @property
    def sigma_rad(self) -> float:
        """Standard deviation of the angle."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def shown(self) -> bool:
        """Whether the picture shows the part there."""
        return self.explained > _LEAST_EXPLAINED and self.kept > _LEAST_KEPT


@dataclass(frozen=True)
class CompositeModel:
    """Cells (cells,) at ``radius_px`` and ``phi_rad``, counter-clockwise, at angle zero.

    ``cover`` and ``level`` with their slopes by radius [1/px] and angle [1/rad]; ``behind`` is the
    background's picture (height, width); ``block`` numbers the cells by their place: of half as
    large samples, as those of colour are (``grain`` 2), the residuals are correlated twice as far.
    """

    pivot_px: tuple[float, float]
    radius_px: Array
    phi_rad: Array
    cover: Array
    level: Array
    slopes: Array
    behind: Single
    block: Index
    step_rad: float
    grain: int = 1

    @classmethod
    def of(
        cls, pictures: Single, angle_rad: Array, pivot_px: tuple[float, float],
        cover: Single, view: PolarView, usual: Single | None = None, grain: int = 1,
    ) -> CompositeModel:  # fmt: skip
        """Of a part that is not blurred, learnt as ``PartRaster.of`` does."""
        return cls.on(PartRaster.of(pictures, angle_rad, pivot_px, cover, view, usual, grain))

    @classmethod
    def on(
        cls, raster: PartRaster, reach_rad: float = 0.0, most: int = _MOST_CELLS
    ) -> CompositeModel:
        """From the part's raster: ``most`` of the cells that a blur over ``reach_rad`` reaches."""
        view, soft, level = raster.view, raster.cover, raster.level
        rows, columns = np.nonzero(raster.reached(reach_rad))
        every = 1 + rows.size // most
        rows, columns = rows[::every], columns[::every]
        step = view.step_rad
        by_angle = [(np.roll(f, -1, 1) - np.roll(f, 1, 1)) / (2.0 * step) for f in (soft, level)]
        by_radius = [np.gradient(f, view.step_px, axis=0) for f in (soft, level)]
        radius = np.asarray(view.radius_px[rows], np.float64)
        side = _BLOCK_PX * raster.grain
        block = (radius // side).astype(int) * 100_000
        block += (columns * step * radius // side).astype(int)
        return cls(
            view.pivot_px, radius, np.asarray(columns * step), soft[rows, columns].astype(float),
            level[rows, columns].astype(float),
            np.stack([f[rows, columns] for f in (*by_angle, *by_radius)]).astype(np.float64),
            raster.behind, np.asarray(np.unique(block, return_inverse=True)[1], np.intp),
            step * every, raster.grain,
        )  # fmt: skip

    def fit(self, picture: Single, angle_rad: float, shifted: bool = False) -> PoseFit | None:
        """Gauss-Newton from an angle, the shift left at zero unless ``shifted``; None where it
        diverges, or there are no cells."""
        if self.radius_px.size == 0:
            return None
        converged, told = pose_of(
            picture, *self._cells, self.block, self._ahead, angle_rad, 3 if shifted else 1,
            self._held_px2, self.step_rad,
        )  # fmt: skip
        return PoseFit(*told) if converged else None

    def left(self, picture: Single, fit: PoseFit) -> tuple[Array, Array, Array]:
        """What a fit leaves of a picture (cells,), its slopes by angle [1/rad] and shift [1/px]
        (3, cells), and the cells' weights (cells,)."""
        left, rows, area, _ = residuals(picture, *self._cells, fit.angle_rad, fit.shift_px)
        weight = np.empty_like(left)
        weights_of(left, area, fit.noise, weight)
        return left, rows, weight

    def squares(self, picture: Single, angle_rad: float, turn_rad: float = 0.0) -> Array:
        """The squared residuals (cells,) of a picture fitted from an angle, large ones limited; NaN
        where it does not fit, and beyond the picture.

        As a rolling shutter shows the part that turns by ``turn_rad`` from the first row's time to
        the last one's; its angle is that at the middle row's.
        """
        if self.radius_px.size == 0:
            return np.empty(0)
        found: Array = squares_of(picture, *self._cells, angle_rad, turn_rad, self._held_px2)
        return found

    def fits(
        self, pictures: Single, angle_rad: Array, shifted: bool = False
    ) -> list[PoseFit | None]:
        """Of pictures (n, height, width), each as ``fit`` does from its angle (n,)."""

        def fitted(number: int) -> PoseFit | None:
            return self.fit(pictures[number], float(angle_rad[number]), shifted)

        return threaded(fitted, range(len(pictures)))

    @property
    def _held_px2(self) -> float:
        """How large the cells are over which residuals are correlated."""
        return _CORRELATED_PX2 * self.grain**2 / self.step_rad

    @cached_property
    def _cells(self) -> tuple[Single, tuple[float, float], Array, Array, Array, Array, Array]:
        """What the compiled passes take of it."""
        directions = np.stack([np.cos(self.phi_rad), np.sin(self.phi_rad)])
        return (
            self.behind, self.pivot_px, self.radius_px, directions, self.cover, self.level,
            self.slopes,
        )  # fmt: skip

    @cached_property
    def _ahead(self) -> Mask:
        """The cells ahead of the direction of the part's middle."""
        weight = self.cover * self.radius_px**2
        cos, sin = self._cells[3]
        return np.asarray(sin * (weight @ cos) - cos * (weight @ sin) > 0.0)


def pivot_step(angle_rad: Array, shifts_px: Array, covariances: Array) -> tuple[Array, Array]:
    """By how much the pivot is off (2,) [px], and the covariance of that (2, 2).

    From the part's shifts (n, 2) at its angles (n,), with their covariances (n, 2, 2): a bar's
    shift along itself is little known. A pivot that is off by d shifts the part by ``(1 - R) d``;
    an error of the part's own picture turns with it. Both by weighted least squares.
    """
    turns = turning(angle_rad)
    rows = np.concatenate([np.eye(2) - turns, turns], axis=2)
    white = np.linalg.inv(np.linalg.cholesky(covariances + _COMMON_PX**2 * np.eye(2)))
    known = (white @ rows).reshape(-1, 4)
    target = (white @ shifts_px[:, :, None]).reshape(-1)
    prior = np.diag([1e-2, 1e-2, 1.0, 1.0])  # the picture's own error is a pixel or so
    inverse = np.linalg.inv(known.T @ known + prior)
    found = inverse @ (known.T @ target)
    left = target - known @ found
    spread = max(float(np.median(np.abs(left))) / 0.6745, 0.5)
    return found[:2], inverse[:2, :2] * spread**2
