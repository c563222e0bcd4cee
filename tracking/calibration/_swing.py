"""The surface's plane from its own swing: its points must move on circles about one centre.

A plane that turns about an axis normal to it moves in the picture by ``H^-1 R(angle) H``. The fixed
points of that motion are the pivot and the images of the two circular points, so the swing alone
determines H up to a similarity, without any focal length (Hartley and Zisserman 2004, 2.7; Fremont
and Chellali 2004 for points on a turntable). Seen obliquely, circles are ellipses; here all points'
ellipses are fitted at once, as circles in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, rms
from servosight.tracking.calibration._swing_features import LEAST_FRAMES, Tracks
from servosight.tracking.core import (
    Index,
    Lens,
    MotionPlane,
    inverse,
    like_picture,
    mapped,
    one_sigma,
    turning,
)

_ROUNDS = 30
_SURE = 5.0  # sigma: features also have a common error with the view, of some sigma
_LEAST_WEIGHT = 6.0
_STRONGEST = 5.0  # stretch or horizon: a camera 85 deg off the axis makes 1.2 of the first
_FARTHEST = 1e3  # distance of a point from the pivot, in half widths of the picture
_OWN = 6  # unknowns beside the angles: shape of the plane 4, pivot 2


@dataclass(frozen=True)
class Swing:
    """The plane of motion found from a swing.

    ``angle_rad`` (frames,) with the first at zero; ``rigid_rad`` the angles if the picture is taken
    as the plane; ``shared_rad`` (frames, 4) the error of their differences from the first where the
    plane is off by one sigma, along each axis of its covariance.
    """

    plane: MotionPlane
    pivot_px: tuple[float, float]
    angle_rad: Array
    rigid_rad: Array
    shared_rad: Array

    @property
    def doubt_rad(self) -> Array:
        """Sigma of the angles' differences from the first due to the plane's; (frames,)."""
        return np.asarray(np.sqrt((self.shared_rad**2).sum(1)))

    @property
    def gain_rad(self) -> float:
        """The rms error of angles measured in the picture without correction."""
        return float(np.std(self.angle_rad - self.rigid_rad))

    @property
    def significant(self) -> bool:
        """True where the picture is surely not the plane: the correction far exceeds its sigma."""
        return self.gain_rad > _SURE * rms(self.doubt_rad)

    def shared_at(self, angle_rad: Array) -> Array:
        """``shared_rad`` at other angles (n,) relative to the first frame's; (n, 4)."""
        order = np.argsort(self.angle_rad)
        known, shared = self.angle_rad[order], self.shared_rad[order]
        return np.column_stack([np.interp(angle_rad, known, column) for column in shared.T])


def calibrate_swing(tracks: Tracks, lens: Lens | None = None) -> Swing | None:
    """The plane in which all points move on circles about one pivot; None where none is found.

    Least squares over the plane's shape, the pivot, the frames' angles and the points themselves,
    the last by variable projection; Tukey's weights against false matches.
    """
    straight = lens.straight(tracks.xy_px) if lens is not None else tracks.xy_px
    middle = 0.5 * (np.array(tracks.shape[1::-1]) - 1.0)
    size = float(middle[0])
    seen = _SwingPoints((straight - middle) / size, tracks.point, tracks.frame)
    free = seen.start()
    if free is None:
        return None
    rigid = seen.solve(free, fixed=4)
    full = seen.solve(rigid.values, fixed=0) if rigid is not None else None
    if rigid is None or full is None:
        return None
    usable = full.usable & rigid.usable
    if usable.sum() < LEAST_FRAMES or not usable[0]:
        return None
    matrix = _matrix(full.values[:4])
    pivot = mapped(matrix, full.values[None, 4:_OWN])[0] * size + middle
    scale = np.array([[1.0 / size, 0.0, 0.0], [0.0, 1.0 / size, 0.0], [0.0, 0.0, 1.0]])
    scale[:2, 2] = -middle / size
    plane = MotionPlane(like_picture(inverse(matrix) @ scale, middle), lens)
    x, y = lens.bent(pivot[None])[0] if lens is not None else pivot
    return Swing(
        plane,
        (float(x), float(y)),
        full.angle_rad[usable],
        rigid.angle_rad[usable],
        full.shared_rad()[usable],
    )


def _matrix(shape: Array) -> Array:
    """From the plane to the picture (3, 3), by four numbers: stretch (a, b), horizon (c, d).

    The stretch is symmetric with determinant one: a similarity does not change angles.
    """
    a, b, c, d = shape
    size = np.hypot(a, b)
    wave = np.sinh(size) / size if size > 1e-9 else 1.0
    stretch = np.cosh(size) * np.eye(2) + wave * np.array([[a, b], [b, -a]])
    matrix = np.zeros((3, 3))
    matrix[:2, :2], matrix[2] = stretch, (c, d, 1.0)
    return matrix


@dataclass(frozen=True)
class _SwingFit:
    """Solution, its covariance by clusters (points), and the frames in which enough points fit."""

    values: Array
    covariance: Array
    normal: Array
    usable: NDArray[np.bool_]

    @property
    def angle_rad(self) -> Array:
        """Each frame's angle against the first's."""
        return np.append(0.0, self.values[_OWN:])

    def shared_rad(self) -> Array:
        """Change of each frame's angle, relative to the first's, with the plane's shape.

        (frames, 4), for one sigma of the shape along each axis of its covariance.
        """
        passed = -np.linalg.lstsq(self.normal[4:, 4:], self.normal[4:, :4], rcond=1e-12)[0][2:]
        return np.vstack([np.zeros(4), passed @ one_sigma(self.covariance[:4, :4])])


@dataclass(frozen=True)
class _SwingPoints:
    xy: Array
    point: Index
    frame: Index

    def start(self) -> Array | None:
        """Angles and pivot if the picture is taken as the plane; None where nothing turns."""
        count = int(self.frame.max()) + 1
        angles = np.zeros(count)
        rows, values = [], []
        home = self.frame == 0
        place = np.full((int(self.point.max()) + 1, 2), np.nan)
        place[self.point[home]] = self.xy[home]
        for frame in range(1, count):
            here = self.frame == frame
            before, after = place[self.point[here]], self.xy[here]
            known = np.isfinite(before[:, 0])
            if known.sum() < 4:
                return None
            before, after = before[known], after[known]
            b, a = before - before.mean(0), after - after.mean(0)
            cross = (b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]).sum()
            angles[frame] = -np.arctan2(cross, (a * b).sum())
            turn = turning(angles[frame])
            rows.append(np.eye(2) - turn)
            values.append(after.mean(0) - turn @ before.mean(0))
        stacked = np.vstack(rows)
        if np.linalg.svd(stacked, compute_uv=False)[-1] < 0.01:
            return None
        pivot = np.linalg.lstsq(stacked, np.concatenate(values), rcond=None)[0]
        return np.concatenate([np.zeros(4), pivot, angles[1:]])

    def solve(self, values: Array, fixed: int) -> _SwingFit | None:
        """Gauss-Newton from ``values`` with the first ``fixed`` unknowns kept as they are.

        None where it diverges, as it does on points that do not turn about a common pivot.
        """
        points = self._points(values)
        values = values.copy()
        for _ in range(_ROUNDS):
            residuals, slopes, own = self._linear(values, points)
            if not np.abs(residuals).max() < _FARTHEST:  # a point passed the horizon
                return None
            weight = _tukey(residuals)
            residuals, slopes, solved = self._projected(
                residuals, slopes[:, :, fixed:], own, weight
            )
            normal, right = _normal(residuals, slopes, weight)
            step = -np.linalg.lstsq(normal, right, rcond=1e-12)[0]
            values[fixed:] += step
            points -= solved[:, :, 0] + solved[:, :, 1:] @ step
            if not (np.abs(values[:4]).max() < _STRONGEST and np.abs(points).max() < _FARTHEST):
                return None
            if np.abs(step).max() < 1e-9:
                break
        raw, slopes, own = self._linear(values, points)
        if not np.abs(raw).max() < _FARTHEST:
            return None
        weight = _tukey(raw)
        residuals, slopes, _ = self._projected(raw, slopes, own, weight)
        normal, _ = _normal(residuals, slopes, weight)
        used = int(np.count_nonzero(weight))
        freedom = float(np.maximum(2 * used - values.size - 2 * len(points), 1))
        # Summed over a point's frames first: a feature's own bias is one error, not many.
        sums = np.zeros((len(points), values.size))
        np.add.at(sums, self.point, np.einsum("nk,nkg->ng", weight[:, None] * residuals, slopes))
        bread = np.linalg.pinv(normal, rcond=1e-12) / _influence_slope(weight)
        covariance = bread @ (sums.T @ sums) @ bread * (2.0 * used / freedom)
        usable = np.bincount(self.frame, weight) > _LEAST_WEIGHT
        return _SwingFit(values, covariance, normal, usable)

    def _points(self, values: Array) -> Array:
        """Positions of the points in the plane about the pivot, at the first angle; (points, 2)."""
        angle = np.append(0.0, values[_OWN:])[self.frame]
        arm = mapped(inverse(_matrix(values[:4])), self.xy) - values[4:_OWN]
        cos, sin = np.cos(angle), np.sin(angle)
        back = np.stack([cos * arm[:, 0] - sin * arm[:, 1], sin * arm[:, 0] + cos * arm[:, 1]], 1)
        count = np.bincount(self.point)
        return np.stack([np.bincount(self.point, column) / count for column in back.T], 1)

    def _linear(self, values: Array, points: Array) -> tuple[Array, Array, Array]:
        """Model less picture (n, 2), and its slopes by the unknowns (n, 2, unknowns) and the
        point's own place (n, 2, 2)."""
        matrix = _matrix(values[:4])
        angle = np.append(0.0, values[_OWN:])[self.frame]
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.stack([np.stack([cos, sin], 1), np.stack([-sin, cos], 1)], 1)
        arm = np.einsum("nij,nj->ni", turn, points[self.point])
        flat = arm + values[4:_OWN]
        scale = 1.0 / (1.0 + flat @ values[2:4])
        place = flat @ matrix[:2, :2].T * scale[:, None]
        by_flat = scale[:, None, None] * (matrix[:2, :2] - place[:, :, None] * values[2:4])
        slopes = np.zeros((len(place), 2, values.size))
        for k in range(2):
            bit = np.zeros(4)
            bit[k] = 1e-6
            stretch = (_matrix(values[:4] + bit) - _matrix(values[:4] - bit))[:2, :2] / 2e-6
            slopes[:, :, k] = flat @ stretch.T * scale[:, None]
            slopes[:, :, 2 + k] = -place * (flat[:, k] * scale)[:, None]
        slopes[:, :, 4:_OWN] = by_flat
        along = np.stack([arm[:, 1], -arm[:, 0]], 1)
        moves = np.flatnonzero(self.frame)
        slopes[moves, :, _OWN + self.frame[moves] - 1] = np.einsum("nij,nj->ni", by_flat, along)[
            moves
        ]
        return place - self.xy, slopes, by_flat @ turn

    def _projected(
        self, residuals: Array, slopes: Array, own: Array, weight: Array
    ) -> tuple[Array, Array, Array]:
        """Residuals and slopes with the points' positions eliminated, and the positions' solution.

        ``solved`` (points, 2, 1 + unknowns): the step of a position is minus its first column,
        minus the others times the step of the unknowns.
        """
        count = int(self.point.max()) + 1
        right = np.concatenate([residuals[:, :, None], slopes], axis=2)
        normal, sums = np.zeros((count, 2, 2)), np.zeros((count, 2, right.shape[2]))
        weighed = weight[:, None, None] * own.transpose(0, 2, 1)
        np.add.at(normal, self.point, weighed @ own)
        np.add.at(sums, self.point, weighed @ right)
        solved = np.asarray(np.linalg.solve(normal + 1e-12 * np.eye(2), sums), np.float64)
        right = right - own @ solved[self.point]
        return right[:, :, 0], right[:, :, 1:], solved


def _influence_slope(weight: Array) -> float:
    """Mean slope of Tukey's influence over its mean weight; with u^2 = 1 - sqrt(weight)."""
    inside = np.sqrt(weight[weight > 0])
    return float(np.mean(inside * (3.0 * inside - 2.0)) / np.mean(inside**2))


def _tukey(residuals: Array) -> Array:
    """Weights (n,) that fall to zero at 4.7 robust standard deviations."""
    scale = 4.7 * _robust(residuals) + 1e-9
    return np.asarray(np.clip(1.0 - (residuals**2).sum(1) / scale**2, 0.0, None) ** 2)


def _robust(residuals: Array) -> float:
    """Standard deviation along one axis, from the median distance."""
    return float(np.median(np.hypot(*residuals.T))) / 1.1774


def _normal(residuals: Array, slopes: Array, weight: Array) -> tuple[Array, Array]:
    count = slopes.shape[2]
    rows = slopes.reshape(-1, count)
    weighed = rows * np.repeat(weight, 2)[:, None]
    return weighed.T @ rows, weighed.T @ residuals.ravel()
