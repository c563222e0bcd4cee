"""Whether an error is white, and whether it follows the command.

The two residual tests of system identification (Ljung, System Identification, 2nd ed., 1999,
section 16.6). The models here are simulated from the command alone, as output-error models are:
whiteness of their errors is not required, because the noise of the measurement may be
autocorrelated; the errors must be independent of the command. The band of that test allows for
coloured errors. Missing samples remove pairs, and uneven times count as the nearest even ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincc, ndtri

from servosight.diagnose.residuals._samples import Samples, autocovariance, lagged_sums, on_grid
from servosight.models.core import Array, Recording

LEVELS = (0.95, 0.99)
"""Confidence of the bands."""
LONGEST_FILTER_S = 0.6
_TAPS = 24
_AHEAD_S = 0.05
_RIDGE = 1e-4


Input = Callable[[Recording, Array], Array]
"""An input of the servo at given times."""


def command_input(recording: Recording, time_s: Array) -> Array:
    """The command."""
    return recording.command_at(time_s)


@dataclass(frozen=True)
class Correlation:
    """Correlation coefficients over time lags, and what chance allows.

    ``lag_s``, ``value`` and ``sigma`` (lags,): the band of a level is sigma times :func:`quantile`.
    ``p``: how often chance shows as much over all lags.
    """

    lag_s: Array
    value: Array
    sigma: Array
    p: float

    @property
    def peak(self) -> int:
        """The lag that stands out most from its band."""
        return int(np.argmax(np.abs(self.value) / np.maximum(self.sigma, 1e-12)))


def quantile(level: float) -> float:
    """Half the width of a normal band of that level, in sigmas."""
    return float(ndtri(0.5 + 0.5 * level))


def whiteness(samples: Sequence[Samples]) -> Correlation:
    """Autocorrelation of the error at lags from one sample on.

    ``p`` is Ljung and Box's (Biometrika 65 (1978) 297), where samples are missing with the pairs
    that there are (Stoffer and Toloi, Statistics and Probability Letters 13 (1992) 391).
    """
    covariance, pairs = autocovariance(samples, _centred(samples))
    count = float(pairs[0])
    seen = pairs > 0.0
    seen[0] = False
    value = covariance[seen] / max(float(covariance[0]), 1e-300)
    statistic = (count + 2.0) / count * float(np.sum(pairs[seen] * value**2))
    lag_s = np.asarray(np.arange(covariance.size)[seen] * _step_s(samples), dtype=np.float64)
    p = float(gammaincc(0.5 * value.size, 0.5 * statistic)) if value.size else 1.0
    return Correlation(lag_s, value, 1.0 / np.sqrt(pairs[seen]), p)


def independence(samples: Sequence[Samples], of: Input = command_input) -> Correlation:
    """Correlation of the error with an input ``lag_s`` before it, positive lags only.

    The input is the command, unless ``of`` gives another. The variance under independence is sum
    R_e(k) R_u(k) / pairs (Ljung, equation 16.65 with both signals coloured); ``p`` is that of the
    largest of all lags, each counted (Bonferroni).
    """
    errors, inputs = _centred(samples), _centred(samples, of)
    lags = min(one.reach for one in samples)
    sums, pairs = np.zeros(lags + 1), np.zeros(lags + 1)
    for one, error, given in zip(samples, errors, inputs, strict=True):
        there = on_grid(one, np.ones(error.size))
        sums += lagged_sums(on_grid(one, given), on_grid(one, error), lags)
        pairs += lagged_sums(there, there, lags)
    pairs = np.maximum(np.round(pairs), 1.0)
    of_error, _ = autocovariance(samples, errors)
    of_input, _ = autocovariance(samples, inputs)
    scale = np.sqrt(max(float(of_error[0] * of_input[0]), 1e-300))
    taper = 1.0 - np.arange(lags + 1) / (lags + 1)
    product = taper * of_error * of_input / scale**2
    # A taper leaves a spectrum that is nowhere negative; what chance takes off is bounded.
    variance = max(float(product[0] + 2.0 * np.sum(product[1:])), 0.05)
    sigma = np.sqrt(variance / pairs)
    value = sums / pairs / scale
    largest = float(np.max(np.abs(value) / sigma))
    p = float(gammaincc(0.5, 0.5 * largest**2)) * value.size
    lag_s = np.arange(lags + 1, dtype=np.float64) * _step_s(samples)
    return Correlation(np.asarray(lag_s), value, np.asarray(sigma), min(p, 1.0))


def linear_share(samples: Sequence[Samples], of: Input = command_input) -> float:
    """Share of the squared error that a freer linear filter of an input takes at most.

    The input is the command, unless ``of`` gives another. A finite impulse response of 24 taps over
    0.6 s and a little ahead, fitted to the samples that it is judged on. Held out in turn, blocks
    of a chirp would ask for what others do not excite.
    """
    table = np.vstack([_delayed(one, of)[one.scored] for one in samples])
    error = np.concatenate(
        [e[one.scored] for one, e in zip(samples, _centred(samples), strict=True)]
    )
    normal = table.T @ table
    if not normal.any():  # the input rests throughout what is scored
        return 0.0
    normal += _RIDGE * np.trace(normal) / _TAPS * np.eye(_TAPS)
    left = error - table @ np.linalg.solve(normal, table.T @ error)
    return float(np.clip(1.0 - np.sum(left**2) / max(np.sum(error**2), 1e-300), 0.0, 1.0))


def _delayed(one: Samples, of: Input) -> Array:
    """The input about its mean at each tap's delay, (samples, taps)."""
    delays = np.linspace(-_AHEAD_S, LONGEST_FILTER_S - _AHEAD_S, _TAPS)
    table = of(one.judged.recording, one.time_s[:, None] - delays)
    return np.asarray(table - table[one.scored].mean())


def _centred(samples: Sequence[Samples], of: Input | None = None) -> list[Array]:
    """Errors, or an input, of each recording about their mean over what is scored."""
    values = [
        one.error_deg if of is None else of(one.judged.recording, one.time_s) for one in samples
    ]
    return [v - v[one.scored].mean() for one, v in zip(samples, values, strict=True)]


def _step_s(samples: Sequence[Samples]) -> float:
    return min(one.step_s for one in samples)
