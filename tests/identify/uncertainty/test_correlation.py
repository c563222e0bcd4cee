"""Coloured residuals: the autoregression that is found, and what it does to sigma."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.uncertainties import assessed, coloured

from servosight.identify.uncertainty import weighted_normal
from servosight.identify.uncertainty._correlation import autoregression


def test_coloured_residuals_widen_sigma(record: Any) -> None:
    """60 noises with neighbours correlated by 0.7: chi-square of 60 within three sigma, 33.

    The textbook's sigma of k is too small by sqrt((1 + 0.7) / (1 - 0.7)) = 2.4 for what is slow:
    its chi-square would be near 300.
    """
    clean = record(4.0, noise_deg=0.0)
    deviations, plain = [], []
    for seed in range(60):
        noise = 0.03 * coloured(0.7, clean.time_s.size, seed)
        found = assessed(replace(clean, angle_deg=clean.angle_deg + noise))
        truth = np.array([1.027, np.log(0.0078), np.log(0.55)])
        off = (found.point - np.append(truth, [0.5, 0.5, 0.0]))[:3]
        deviations.append(off / found.sigma[:3])
        plain.append(off / found.plain_sigma[:3])
    squares, untold = np.sum(np.square(deviations), axis=0), np.sum(np.square(plain), axis=0)
    print(f"chi-square of 60: {squares.round(1)}, without the correlation {untold.round(1)}")
    assert np.all(np.abs(squares - 60.0) < 33.0)
    assert untold[0] > 120.0


def test_the_order_of_an_autoregression_is_found() -> None:
    """5000 samples of known poles: coefficients within three of their sigma, 1 / sqrt(5000)."""
    white = np.random.default_rng(4).normal(size=5_000)
    values = white.copy()
    for i in range(2, values.size):
        values[i] += 1.2 * values[i - 1] - 0.5 * values[i - 2]
    coefficients, variance = autoregression(values, np.ones(values.size, dtype=bool))
    np.testing.assert_allclose(coefficients, [1.2, -0.5], atol=3.0 / np.sqrt(5_000))
    assert variance == pytest.approx(1.0, rel=3.0 * np.sqrt(2.0 / 5_000))


def test_the_spectrum_stands_for_the_toeplitz_matrix() -> None:
    """J'RJ of an autoregression of order 1, against R written out."""
    jacobian = np.random.default_rng(2).normal(size=(400, 3))
    residuals = coloured(0.6, 400, 3)
    scored = np.ones(400, dtype=bool)
    (rho,), variance = autoregression(residuals, scored)
    lag = np.abs(np.subtract.outer(np.arange(400), np.arange(400)))
    written = variance / (1.0 - rho**2) * rho**lag
    np.testing.assert_allclose(
        weighted_normal(jacobian, residuals, scored), jacobian.T @ written @ jacobian, rtol=1e-9
    )
