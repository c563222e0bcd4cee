"""Levenberg-Marquardt descent within box bounds, as an estimator.

Each generation is a batch: the columns of a difference quotient, or one trial point for each of
several dampings. Nocedal and Wright, Numerical Optimization (2006), section 10.3; coordinates at a
bound are frozen while the gradient points outward (projected step, Kelley 1999, section 5.4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.search._estimator import SearchSpace, Stop, StopReason, half_squares
from servosight.models.core import Array

# Factors of the last damping, close to 1 but never 1: along a curved valley it has to change.
_DAMPINGS = np.array([1e-5, 1e-3, 3e-2, 3e-1, 3.0, 300.0])
_QUOTIENT = 1e-5
_INSENSITIVE = 1e-4

FLAT = Stop(StopReason.CONVERGED, "converged: the cost no longer falls")
NO_DESCENT = Stop(StopReason.CONVERGED, "converged: no damping lowers the cost")
GENERATIONS_USED = Stop(
    StopReason.GENERATIONS, "generations spent; start nearer or raise the limit"
)


@dataclass(frozen=True)
class DescentOptions:
    """The search ends where a generation lowers the cost by less than ``tolerance`` of it.

    At most ``generations`` trial steps are made.
    """

    tolerance: float = 1e-5
    generations: int = 30


class LevenbergMarquardt:
    """Descend from ``start`` within ``low`` and ``high``.

    ``scale`` (coordinates,) is the size of a meaningful change of each coordinate: difference
    quotients step by 1e-5 of it plus 1e-5 of the coordinate.
    """

    def __init__(
        self,
        start: Array,
        low: Array,
        high: Array,
        scale: Array,
        options: DescentOptions = DescentOptions(),
    ) -> None:
        self.low, self.high = low, high
        self.point = np.clip(np.asarray(start, dtype=np.float64), low, high)
        self.scale = scale
        self.options = options
        self.generations_left = options.generations
        self.damping = 1.0
        self.stopped: Stop | None = None
        self.cost = np.inf
        self.jacobian: Array | None = None
        self._residual: Array | None = None
        self._steps = np.zeros_like(self.point)
        self._trying = False

    def ask(self) -> Array:
        """The point and its neighbours, or trial points at several dampings."""
        return self._trials() if self._trying else self._neighbours()

    def tell(self, points: Array, residuals: Array) -> None:
        """Take the difference quotient, or move to the best trial."""
        if self._trying:
            self._move(points, residuals)
        else:
            self._differentiate(residuals)

    def resumed(self) -> LevenbergMarquardt:
        """A descent that continues from here, also where this one has stopped."""
        left = replace(self.options, generations=max(self.generations_left, 1))
        following = LevenbergMarquardt(self.point, self.low, self.high, self.scale, left)
        following.damping = self.damping
        return following

    def _neighbours(self) -> Array:
        steps = _QUOTIENT * (self.scale + np.abs(self.point))
        # Step inward where a bound is near, and no further than the opposite bound.
        above, below = self.high - self.point, self.point - self.low
        inward = np.where(below > above, -np.minimum(steps, below), np.minimum(steps, above))
        self._steps = np.where(steps > above, inward, steps)
        return np.vstack([self.point, self.point + np.diag(self._steps)])

    def _differentiate(self, residuals: Array) -> None:
        self._residual = residuals[0]
        self.cost = float(half_squares(residuals[:1])[0])
        steps = np.where(self.low == self.high, np.inf, self._steps)  # held: nothing changes
        self.jacobian = ((residuals[1:] - residuals[0]) / steps[:, None]).T
        self._trying = True

    def _trials(self) -> Array:
        assert self.jacobian is not None
        assert self._residual is not None
        gradient = self.jacobian.T @ self._residual
        outward = ((self.point <= self.low) & (gradient > 0)) | (
            (self.point >= self.high) & (gradient < 0)
        )
        free = np.flatnonzero(~outward & (self.low < self.high))
        normal = self.jacobian[:, free].T @ self.jacobian[:, free]
        # A coordinate without influence must not take huge steps: its column counts as longer.
        size = (self.scale + np.abs(self.point))[free]
        sensitivity = np.sqrt(np.diag(normal)) * size
        weakest = max(_INSENSITIVE * float(sensitivity.max(initial=0.0)), 1e-30)
        root = np.maximum(sensitivity, weakest) / size
        # Where simulations fail a quotient may exceed all numbers, and tells nothing then.
        scaled = np.nan_to_num(normal / np.outer(root, root), nan=0.0, posinf=0.0, neginf=0.0)
        values, vectors = np.linalg.eigh(scaled)
        downhill = vectors.T @ (-gradient[free] / root)
        trials = np.tile(self.point, (_DAMPINGS.size, 1))
        for trial, damping in zip(trials, _DAMPINGS * self.damping, strict=True):
            step = vectors @ (downhill / (np.maximum(values, 1e-14) + damping)) / root
            trial[free] += step
        return np.clip(trials, self.low, self.high)

    def _move(self, points: Array, residuals: Array) -> None:
        costs = half_squares(residuals)
        best = int(np.argmin(costs))
        gain = self.cost - float(costs[best])
        self.generations_left -= 1
        if gain > 0.0:
            step = np.abs(points[best] - self.point) / (self.scale + np.abs(self.point))
            self.point = points[best].copy()
            small = gain <= self.options.tolerance * self.cost
            self.damping = float(np.clip(self.damping * _DAMPINGS[best] / 0.1, 1e-6, 1e4))
            self.cost = float(costs[best])
            self._trying = False
            if small or float(step.max()) < 1e-9:
                self.stopped = FLAT
        else:
            self.damping *= 1e3
            if self.damping > 1e7:
                self.stopped = NO_DESCENT
        if self.generations_left <= 0 and self.stopped is None:
            self.stopped = GENERATIONS_USED


def gradient(space: SearchSpace) -> LevenbergMarquardt:
    """A descent from the first guess or, without one, from a point drawn within the bounds."""
    if space.guesses is not None and len(space.guesses):
        start = space.guesses[0]
    else:
        start = np.random.default_rng(space.seed).uniform(space.low, space.high)
    return LevenbergMarquardt(start, space.low, space.high, space.scale)
