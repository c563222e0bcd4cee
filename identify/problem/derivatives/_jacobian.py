"""The Jacobian of the residuals by difference quotients, and the size of their steps."""

from __future__ import annotations

import numpy as np

from servosight.identify.problem._problem import Problem
from servosight.models.core import Array


def coordinate_scale(problem: Problem, point: Array) -> Array:
    """Size of a meaningful change of each coordinate."""
    scale = np.ones(point.size)
    for j, coordinate in enumerate(problem.coordinates):
        low, high = coordinate.bounds
        scale[j] = min(1.0, high - low) if not coordinate.logarithmic else 1.0
        if coordinate.parameter.unit == "s" and not coordinate.logarithmic:
            scale[j] = 0.05
        if coordinate.parameter.reciprocal:
            scale[j] = max(abs(point[j]), 1e-4)
        if coordinate.parameter.free_unit:
            scale[j] = abs(point[j]) or 1.0
    return scale


def difference_quotient(problem: Problem, point: Array, scale: Array) -> Array:
    """Central difference Jacobian of the residuals, (scored, coordinates)."""
    low, high = problem.bounds
    steps = 1e-4 * (scale + np.abs(point))
    up = np.clip(point + np.diag(steps), low, high)
    down = np.clip(point - np.diag(steps), low, high)
    answers = problem.residuals(np.vstack([up, down]))
    width = np.where(low == high, np.inf, np.diag(up) - np.diag(down))  # held: nothing changes
    count = point.size
    return np.asarray(((answers[:count] - answers[count:]) / width[:, None]).T)
