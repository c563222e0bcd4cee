"""The error over angle, speed and size of the motion, on errors made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from support.made_errors import NOISE_DEG, case, direction, found_in

from servosight.diagnose.residuals import held_out_samples, profile, swings
from servosight.models.excitation import Excitation


def test_friction_lags_at_any_speed() -> None:
    """Behind by 0.30 deg whichever way it moves: share and size come from the error itself."""
    judged = case(lambda t, y: -0.3 * direction(t, y))
    found = found_in(judged)
    assert "lags the model by 0.30 deg, at any speed" in found["speed"].sentence
    assert found["speed"].size_deg == pytest.approx(0.3, abs=0.05)
    assert "linearity" in found
    assert found["speed"].p < 1e-6


def test_lag_that_grows_with_speed() -> None:
    found = found_in(case(lambda t, y: -0.01 * np.gradient(y, t)))
    assert "moving fast, it lags" in found["speed"].sentence
    assert "grows with speed" in found["motion"].sentence


def test_a_load_that_depends_on_position() -> None:
    judged = case(lambda t, y: y**2 / 200.0)
    found = found_in(judged)
    assert "depends on the angle" in found["angle"].sentence
    bins = profile(held_out_samples([judged]), "angle")
    assert bins is not None
    np.testing.assert_allclose(bins.median_deg, bins.x**2 / 200.0, atol=0.1)
    # 36 bands of 95 % at most miss a few; bins are wide where the angle seldom is.
    middle = np.abs(bins.x) < 8.0
    missed = (bins.x**2 / 200.0 < bins.low_deg) | (bins.x**2 / 200.0 > bins.high_deg)
    assert np.mean(missed[middle]) < 0.5


def test_an_error_that_grows_faster_than_the_motion() -> None:
    """Swings of 2 to 20 deg with errors that go as their square."""
    t = np.arange(0.0, 20.0, 0.004)
    size = 1.0 + 9.0 * t / 20.0
    rows = Excitation(t, size * np.sin(2.0 * np.pi * 1.5 * t))
    judged = case(
        lambda t, y: 0.01 * (1.0 + 9.0 * t / 20.0) ** 2 * np.sin(40.0 * t), excitation=rows
    )
    found = swings(held_out_samples([judged]), NOISE_DEG)
    assert found is not None
    assert found.power == pytest.approx(2.0, abs=3.0 * max(found.sigma, 0.05))
    assert "grows faster than the motion" in found_in(judged)["amplitude"].sentence
