"""Problems of two parameters whose least cost is known, for tests of estimators."""

from __future__ import annotations

import numpy as np

from servosight.identify.search import LevenbergMarquardt
from servosight.models.core import Array

LOW, HIGH = np.full(2, -2.0), np.full(2, 2.0)


def rosenbrock(points: Array) -> Array:
    """Residuals of 100 (y - x^2)^2 + (1 - x)^2; its minimum is 0 at (1, 1)."""
    x, y = points.T
    return np.stack([10.0 * (y - x**2), 1.0 - x], axis=1)


def descent(start: Array) -> LevenbergMarquardt:
    return LevenbergMarquardt(start, LOW, HIGH, np.ones(2))


def rippled(points: Array) -> Array:
    """A bowl about (0.5, 0.5) with many local minima; its least cost is 0."""
    away = points - 0.5
    return np.stack([away, np.sin(4.0 * away)], axis=2).reshape(len(points), -1)
