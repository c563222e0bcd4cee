"""Covariance of a fit whose model misses something: what another run of the servo would give.

Far above the noise an error is no noise: it depends on the motion, repeats where the command does,
and is large in some parts of a recording. Two estimates of what that does to the parameters, each
right where the other is not; the larger counts.

- All autocovariances of the error, times those of the score directions, without any smoothing
  (Robinson, Econometrica 66 (1998) 1163): right where error and motion are stationary, also where
  both repeat, so that ten periods tell no more than one.
- The jackknife over blocks of time (Cameron and Miller, Journal of Human Resources 50 (2015) 317,
  CR3): right where the error grows with the motion.

Both are linear: nothing is fitted anew.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Mask

BLOCK_S = 1.0
"""Longer than an error of a servo is correlated with itself, shorter than most recordings."""
_FEWEST_BLOCKS = 10
_MOST_BLOCKS = 1000
_LEVERAGE = 0.9
"""A block that alone determines a parameter is not left out whole."""
_LEAST_FREEDOM = 0.25


def misfit_covariance(
    jacobians: Sequence[Array],
    residuals: Sequence[Array],
    masks: Sequence[Mask],
    times_s: Sequence[Array],
    inverse: Array,
) -> Array:
    """Covariance (coordinates, coordinates) for errors that are the model's own.

    For each recording the Jacobian (samples, coordinates) and the residuals (samples,), both zero
    where ``masks`` is False, and its times [s]. ``inverse`` is (J'J)^-1.
    """
    spectra = [_spectrum(one, mask) for one, mask in zip(residuals, masks, strict=True)]
    meat = sum(_weighted(one, power) for one, power in zip(jacobians, spectra, strict=True))
    freedom = sum(_freedom(power) for power in spectra)
    left = max(freedom - inverse.shape[0], _LEAST_FREEDOM * freedom)
    stationary = inverse @ meat @ inverse * (freedom / left)
    blocks = _jackknife(jacobians, residuals, times_s, inverse)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(np.diag(blocks) / np.diag(stationary))
    wider = np.where(ratio > 1.0, ratio, 1.0)
    return np.asarray(stationary * np.outer(wider, wider))


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


def _jackknife(
    jacobians: Sequence[Array],
    residuals: Sequence[Array],
    times_s: Sequence[Array],
    inverse: Array,
) -> Array:
    """Covariance from leaving out one block of time after the other, to first order."""
    duration_s = sum(float(time_s[-1] - time_s[0]) for time_s in times_s)
    block_s = min(BLOCK_S, duration_s / _FEWEST_BLOCKS)
    block_s = max(block_s, duration_s / _MOST_BLOCKS)
    root = np.linalg.cholesky(inverse + 1e-12 * np.diag(np.diag(inverse)))
    moves = []
    for jacobian, errors, time_s in zip(jacobians, residuals, times_s, strict=True):
        number = ((time_s - time_s[0]) // block_s).astype(np.int64)
        edges = np.flatnonzero(np.diff(number, prepend=-1))
        for part, error in zip(
            np.split(jacobian, edges[1:]), np.split(errors, edges[1:]), strict=True
        ):
            if not error.any():
                continue
            scaled = part @ root
            values, vectors = np.linalg.eigh(scaled.T @ scaled)
            score = vectors.T @ (scaled.T @ error)
            moves.append(vectors @ (score / (1.0 - np.minimum(values, _LEVERAGE))))
    count = len(moves)
    if count < 2:
        return np.zeros(inverse.shape)
    stacked = root @ np.array(moves).T
    return np.asarray((count - 1) / count * stacked @ stacked.T)
