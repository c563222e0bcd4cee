"""Uncertainty of a fit from the Jacobian of its residuals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from servosight.identify.problem import Problem
from servosight.models.actuator import Estimate

Array = NDArray[np.float64]

_FLAT = 1e-13


def covariance(jacobian: Array, cost: float, free: NDArray[np.bool_]) -> Array:
    """Covariance of the coordinates, NaN where the data does not determine them.

    s^2 (J'J)^-1 with s^2 the residual variance (Seber and Wild, Nonlinear Regression, 1989,
    section 2.1.2). Coordinates at a bound (``free`` False) are taken as known.
    """
    count = jacobian.shape[1]
    result = np.full((count, count), np.nan)
    columns = np.flatnonzero(free)
    if columns.size == 0:
        return result
    part = jacobian[:, columns]
    norms = np.sqrt(np.einsum("ij,ij->j", part, part))
    seen = norms > 0.0
    columns, part, norms = columns[seen], part[:, seen], norms[seen]
    if columns.size == 0:
        return result
    _, singular, right = np.linalg.svd(part / norms, full_matrices=False)
    variance = 2.0 * cost / max(jacobian.shape[0] - columns.size, 1)
    keep = singular**2 > _FLAT * singular[0] ** 2
    inverse = (right[keep].T / singular[keep] ** 2) @ right[keep]
    # A coordinate with a part in a flat direction is undetermined.
    lost = np.sum(right[~keep] ** 2, axis=0) > 1e-6
    block = variance * inverse / np.outer(norms, norms)
    block[lost, :] = np.nan
    block[:, lost] = np.nan
    result[np.ix_(columns, columns)] = block
    return result


def estimates(
    problem: Problem, point: Array, jacobian: Array, cost: float
) -> tuple[dict[str, Estimate], list[str]]:
    """Shared parameters with their sigmas, and a warning for each that stays undetermined."""
    low, high = problem.bounds
    free = (point > low) & (point < high)
    spread = np.sqrt(np.diag(covariance(jacobian, cost, free)))
    found: dict[str, Estimate] = {}
    warnings = []
    for j, coordinate in enumerate(problem.coordinates[: problem.physical]):
        value = coordinate.from_search(float(point[j]))
        sigma: float | None = float(spread[j] * abs(coordinate.slope(float(point[j]))))
        if not free[j]:
            sigma = None
            warnings.append(
                f"{coordinate.name} rests on a bound of its range, so it has no sigma: this "
                f"recording does not call for it"
            )
        elif sigma is None or not np.isfinite(sigma) or sigma > 10.0 * (abs(value) + 1e-9):
            sigma = None
            warnings.append(
                f"{coordinate.name} cannot be told from this recording: changing it hardly "
                f"changes the prediction; use an excitation that moves it"
            )
        if not np.isfinite(value):
            value = coordinate.from_search(1e-9)
        found[coordinate.name] = Estimate(value, sigma, coordinate.parameter.unit)
    return found, warnings


def own_estimates(
    problem: Problem, point: Array, jacobian: Array, cost: float, name: str
) -> tuple[Estimate, ...]:
    """One of the recordings' own numbers (``bias``), for each recording."""
    low, high = problem.bounds
    free = (point > low) & (point < high)
    spread = np.sqrt(np.diag(covariance(jacobian, cost, free)))
    return tuple(
        Estimate(
            float(point[j]),
            float(spread[j]) if np.isfinite(spread[j]) else None,
            coordinate.parameter.unit,
        )
        for j, coordinate in enumerate(problem.coordinates)
        if coordinate.recording is not None and coordinate.name == name
    )
