"""The error at reversals and at rest, on errors made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from support.made_errors import NOISE_DEG, case, found_in

from servosight.diagnose.residuals import all_samples, held_out_samples, turning_points, turns
from servosight.diagnose.residuals._events import rests
from servosight.models.core import Array
from servosight.models.excitation import Excitation


def test_reversals_are_picked_out() -> None:
    """Late by 0.4 deg for 0.15 s after each turn of a triangle."""
    t = np.arange(0.0, 20.0, 0.004)
    rows = Excitation(t, 15.0 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * 0.5 * t)))

    def late(t: Array, y: Array) -> Array:
        points = turning_points(y)
        out = np.zeros_like(t)
        for place, turn in enumerate(points):
            side = np.sign(y[points[place + 1]] - y[turn]) if place + 1 < points.size else 0.0
            out[(t >= t[turn]) & (t < t[turn] + 0.15)] = -0.4 * side
        return out

    judged = case(late, excitation=rows)
    found = turns(all_samples([judged]))
    assert found is not None
    assert found.after_deg == pytest.approx(-0.4, abs=4.0 * NOISE_DEG)
    said = found_in(judged)
    assert "lags" in said["reversal"].sentence or "beyond" in said["reversal"].sentence
    assert "at reversals" in said["motion"].sentence
    assert (
        "does not grow with speed" in said["motion"].sentence
        or "low speed" in said["motion"].sentence
    )


def test_rests_short_of_the_model() -> None:
    """Steps of 10 deg either way that end 0.2 deg short."""
    t = np.arange(0.0, 30.0, 0.004)
    rows = Excitation(t, 5.0 * np.sign(np.sin(2.0 * np.pi * 0.5 * t + 1e-9)))
    judged = case(lambda t, y: -0.2 * np.sign(y), excitation=rows)
    found = rests(held_out_samples([judged]))
    assert found is not None
    assert found.short_deg == pytest.approx(-0.2, abs=0.02)
    assert "0.20 deg short of" in found_in(judged)["standstill"].sentence


def test_turning_points_are_those_of_the_motion() -> None:
    t = np.linspace(0.0, 4.0, 801)
    points = turning_points(np.sin(2.0 * np.pi * 1.0 * t) + 0.01 * np.sin(2.0 * np.pi * 40.0 * t))
    np.testing.assert_allclose(t[points], 0.25 + 0.5 * np.arange(8), atol=0.02)
    assert turning_points(np.zeros(50)).size == 0
