"""The curve of the surface over the horn: its polynomials, degree and covariance."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from servosight.models.core import Array

HIGHEST_DEGREE = 9
_BLOCKS = 20
_BETTER = 0.99
"""A higher degree is taken where it lowers the error on other stretches to this share."""


def curve(driver_deg: Array, range_deg: tuple[float, float], degree: int) -> Array:
    """Legendre polynomials over the horn's range, (samples, degree + 1)."""
    low, high = range_deg
    return np.asarray(legendre.legvander((2.0 * driver_deg - low - high) / (high - low), degree))


def slopes_of(driver_deg: Array, range_deg: tuple[float, float], degree: int) -> Array:
    """Their derivatives, (samples, degree + 1) [1/deg]."""
    low, high = range_deg
    place = (2.0 * driver_deg - low - high) / (high - low)
    every = [legendre.legval(place, legendre.legder(one)) for one in np.eye(degree + 1)]
    return np.asarray(np.stack(every, axis=1) * (2.0 / (high - low)))


def solved(rows: Array, wanted: Array) -> Array:
    """Least squares by the normal equations: the polynomials are nearly orthogonal."""
    return np.asarray(np.linalg.pinv(rows.T @ rows, hermitian=True) @ (rows.T @ wanted))


def degree_of(place: Array, wanted: Array, range_deg: tuple[float, float]) -> int:
    """The lowest degree beyond which the error on stretches left out hardly falls."""
    block = np.arange(place.size) * _BLOCKS // place.size
    errors: list[float] = []
    for degree in range(1, HIGHEST_DEGREE + 1):
        rows = curve(place, range_deg, degree)
        left = np.empty(place.size)
        for out in range(_BLOCKS):
            kept = block != out
            values = solved(rows[kept], wanted[kept])
            left[~kept] = wanted[~kept] - rows[~kept] @ values
        errors.append(float(np.median(np.abs(left))))
    chosen = 0
    for i in range(1, HIGHEST_DEGREE):
        if errors[i] < _BETTER * errors[chosen]:
            chosen = i
    return chosen + 1


def jackknife(jacobian: Array, residuals: Array) -> Array:
    """Covariance of a least-squares fit from leaving out stretches of time in turn.

    ``jacobian`` (samples, coordinates), ``residuals`` (samples,). The jackknife on blocks, which
    holds where residuals are correlated or are the model's own (Kuensch, Annals of Statistics 17
    (1989), section 2).
    """
    normal = jacobian.T @ jacobian
    block = np.arange(residuals.size) * _BLOCKS // residuals.size
    moves = []
    for out in range(_BLOCKS):
        rows, left = jacobian[block == out], residuals[block == out]
        moves.append(np.linalg.pinv(normal - rows.T @ rows) @ (rows.T @ left))
    spread = np.array(moves) - np.mean(moves, axis=0)
    return np.asarray((_BLOCKS - 1) / _BLOCKS * spread.T @ spread)
