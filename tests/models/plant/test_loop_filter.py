"""The linear loop as a difference equation, beside scipy's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from servosight.models.effects import catalogue
from servosight.models.plant import Plant, loop_filter


@pytest.mark.parametrize("xi", [0.1, 0.6, 1.0, 3.0])
@pytest.mark.parametrize("T", [0.002, 0.02, 0.3])
def test_as_scipy_has_it(T: float, xi: float) -> None:
    """The coefficients and what a motion behind them is."""
    numerator, denominator = loop_filter(T, xi, 1.0 / 120.0)
    top, bottom, _ = cont2discrete(([1.0], [T * T, 2.0 * xi * T, 1.0]), 1.0 / 120.0, "foh")
    np.testing.assert_allclose(numerator, top.ravel(), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(denominator, bottom, rtol=1e-12, atol=1e-15)
    rows = np.random.default_rng(0).normal(size=(3, 500))
    rows.flags.writeable = False
    found = Plant.of(catalogue()).filtered(numerator, denominator, rows[:, ::2])
    expected = lfilter(numerator, denominator, rows[:, ::2], axis=1)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
