"""Autocorrelated residuals: their autocovariance, and its effect on the covariance of a fit.

An autoregression whose order Schwarz's criterion selects, from the Yule-Walker equations (Brockwell
and Davis, Time Series, 1991, section 8.1). Order 0, for white residuals, gives the textbook
covariance exactly; else the sandwich accounts for the correlation (den Haan and Levin, 1997).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Mask

_HIGHEST_ORDER = 40
_SAMPLES_AN_ORDER = 15


def autoregression(residuals: Array, scored: Mask) -> tuple[Array, float]:
    """Coefficients (order,) of e_t = sum a_i e_(t-i) + v_t, and the variance of v [deg^2].

    ``residuals`` (samples,) with gaps where ``scored`` is False.
    """
    filled = np.where(scored, residuals, 0.0)
    count = int(scored.sum())
    orders = min(_HIGHEST_ORDER, count // _SAMPLES_AN_ORDER)
    lags = np.arange(orders + 1)
    pairs = _lagged_products(scored.astype(np.float64), orders)
    # A taper over the lag keeps the spectrum from being negative, as without missing samples.
    covariance = _lagged_products(filled, orders) / np.maximum(pairs, 1.0) * (1.0 - lags / count)
    coefficients = np.empty(0)
    variance = float(covariance[0])
    best = (coefficients, variance)
    least = count * float(np.log(max(variance, 1e-300)))
    for order in range(1, orders + 1):
        if variance <= 0.0:
            break
        ahead = covariance[order] - coefficients @ covariance[order - 1 : 0 : -1]
        reflection = float(ahead) / variance
        if abs(reflection) >= 1.0:
            break
        # Levinson and Durbin's step.
        coefficients = np.append(coefficients - reflection * coefficients[::-1], reflection)
        variance *= 1.0 - reflection**2
        criterion = count * float(np.log(variance)) + order * float(np.log(count))
        if criterion < least:
            least, best = criterion, (coefficients, variance)
    return best


def weighted_normal(jacobian: Array, residuals: Array, scored: Mask) -> Array:
    """J' R J with R the residuals' covariance, for one recording.

    ``jacobian`` (samples, coordinates), zero where not scored. The Toeplitz matrix R is never
    formed: its product is a sum over the spectrum.
    """
    coefficients, variance = autoregression(residuals, scored)
    if coefficients.size == 0:
        return np.asarray(variance * jacobian.T @ jacobian)
    size = 2 * jacobian.shape[0]
    spectrum = variance / np.abs(np.fft.rfft(np.append(1.0, -coefficients), size)) ** 2
    columns = np.fft.rfft(jacobian, size, axis=0)
    twice = np.full(spectrum.size, 2.0)
    twice[0] = twice[-1] = 1.0
    weighted = columns * (twice * spectrum / size)[:, None]
    return np.asarray((columns.conj().T @ weighted).real)


def by_recording(
    masks: Sequence[Mask], jacobian: Array, residuals: Array
) -> tuple[list[Array], list[Array]]:
    """Recordings' own parts of ``jacobian`` (scored, coordinates) and ``residuals`` (scored,).

    For each recording (samples, coordinates) and (samples,), zero where its mask does not score.
    """
    ends = np.cumsum([0, *(int(mask.sum()) for mask in masks)])
    jacobians, errors = [], []
    for mask, first, last in zip(masks, ends, ends[1:], strict=False):
        jacobians.append(np.zeros((mask.size, jacobian.shape[1])))
        jacobians[-1][mask] = jacobian[first:last]
        errors.append(np.zeros(mask.size))
        errors[-1][mask] = residuals[first:last]
    return jacobians, errors


def _lagged_products(values: Array, lags: int) -> Array:
    """Sum of values[t] values[t + lag] for lags 0 to ``lags``."""
    return np.array([values[: values.size - lag] @ values[lag:] for lag in range(lags + 1)])
