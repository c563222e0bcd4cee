"""Profile likelihood: how far a coordinate may move while all others are fitted anew.

Where the surface is no parabola, or ends at a bound, the Jacobian's sigma is wrong, and this is
right (Raue and others, Bioinformatics 25 (2009); Venzon and Moolgavkar, Appl. Statist. 37 (1988)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.identify.problem import Problem
from servosight.identify.search import DescentOptions, LevenbergMarquardt, drive
from servosight.models.core import Array

_BUDGET = 100
_NOTICED = 0.02
"""A refit ends where a generation gains less than this on twice the log-likelihood."""
_TRIES = 6
_CLOSE = (0.7, 1.4)
"""Near the wanted rise its square root is taken to grow with the distance."""
_FURTHEST = 4.0
_STEP_SHARE = 1e3
"""Difference quotients step by 1e-5 of the scale: a hundredth of sigma."""


@dataclass(frozen=True)
class LikelihoodProfile:
    """The likelihood about a fitted ``point`` (coordinates,) of half sum of squares ``cost``.

    ``variance`` of the residuals [deg^2]; ``scale`` (coordinates,) a rough sigma of each;
    ``slopes`` (coordinates, coordinates): how all follow a unit of each, a row for each that moves.
    """

    problem: Problem
    point: Array
    cost: float
    variance: float
    scale: Array
    slopes: Array

    def rise(self, index: int, value: float) -> float:
        """Twice the log-likelihood lost with a coordinate held at ``value``, the rest refitted."""
        low, high = (np.delete(bound, index) for bound in self.problem.bounds)

        def residuals(points: Array) -> Array:
            return self.problem.residuals(np.insert(points, index, value, axis=1))

        moved = self.point + (value - self.point[index]) * self.slopes[index]
        scale = _STEP_SHARE * np.delete(self.scale, index)
        # An exact fit has no cost to compare with: then that of one sample with the variance.
        tolerance = 0.5 * _NOTICED * self.variance / max(self.cost, 0.5 * self.variance)
        options = DescentOptions(tolerance)
        descent = LevenbergMarquardt(np.delete(moved, index), low, high, scale, options)
        return 2.0 * (drive(descent, residuals, _BUDGET).cost - self.cost) / self.variance

    def reach(self, index: int, step: float, level: float = 1.0) -> float | None:
        """Distance at which the rise is ``level``, on the side of ``step``'s sign.

        ``step`` is the first guess. None where a bound comes first.
        """
        bound = self.problem.bounds[0 if step < 0.0 else 1][index]
        room = abs(float(bound - self.point[index]))
        sign = float(np.sign(step))
        near, far = 0.0, np.inf
        distance = min(abs(step), room)
        for _ in range(_TRIES):
            rise = max(self.rise(index, float(self.point[index]) + sign * distance), 1e-12)
            if _CLOSE[0] < rise / level < _CLOSE[1]:
                return min(distance * float(np.sqrt(level / rise)), room)
            if rise < level:
                if distance >= room:
                    return None
                near = distance
            else:
                far = distance
            guess = distance * float(np.clip(np.sqrt(level / rise), 1 / _FURTHEST, _FURTHEST))
            distance = guess if near < guess < far else 0.5 * (near + min(far, room))
            distance = min(distance, room)
        return distance
