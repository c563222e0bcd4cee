"""Covariance of a fit by a stationary error of any correlation, from all its autocovariances.

Those of the error times those of the score directions, without any smoothing (Robinson,
Econometrica 66 (1998) 1163): right also where error and motion both repeat, so that ten periods
tell no more than one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Mask

_LEAST_FREEDOM = 0.25


def stationary_covariance(
    jacobians: Sequence[Array], residuals: Sequence[Array], masks: Sequence[Mask], inverse: Array
) -> Array:
    """(coordinates, coordinates), from each recording's Jacobian and residuals.

    The Jacobian (samples, coordinates) and the residuals (samples,) are zero where ``masks`` is
    False. ``inverse`` is (J'J)^-1.
    """
    spectra = [_spectrum(one, mask) for one, mask in zip(residuals, masks, strict=True)]
    meat = sum(_weighted(one, power) for one, power in zip(jacobians, spectra, strict=True))
    freedom = sum(_freedom(power) for power in spectra)
    left = max(freedom - inverse.shape[0], _LEAST_FREEDOM * freedom)
    return np.asarray(inverse @ meat @ inverse * (freedom / left))


def _spectrum(residuals: Array, scored: Mask) -> Array:
    """Power of the residuals at the frequencies of twice their length [deg^2], (samples + 1,).

    From the autocovariance at all lags; missing samples leave pairs out.
    """
    count, size = residuals.size, 2 * residuals.size
    products = np.fft.irfft(np.abs(np.fft.rfft(residuals, size)) ** 2)[:count]
    pairs = np.fft.irfft(np.abs(np.fft.rfft(scored.astype(np.float64), size)) ** 2)[:count]
    covariance = products / np.maximum(pairs, 1.0) * (1.0 - np.arange(count) / count)
    both = np.concatenate([covariance, [0.0], covariance[:0:-1]])
    return np.maximum(np.fft.rfft(both).real, 0.0)


def _weighted(jacobian: Array, spectrum: Array) -> Array:
    """J' R J with R the Toeplitz matrix of a spectrum at twice as many frequencies as samples."""
    size = 2 * jacobian.shape[0]
    columns = np.fft.rfft(jacobian, size, axis=0)
    twice = np.full(spectrum.size, 2.0)
    twice[0] = twice[-1] = 1.0
    weighted = columns * (twice * spectrum / size)[:, None]
    return np.asarray((columns.conj().T @ weighted).real)


def _freedom(spectrum: Array) -> float:
    """How many independent numbers an error of this spectrum is worth."""
    square = float(np.sum(spectrum**2))
    # Twice the length samples each frequency twice: a sine and a cosine for every second one.
    return float(np.sum(spectrum)) ** 2 / square if square > 0.0 else 0.0
