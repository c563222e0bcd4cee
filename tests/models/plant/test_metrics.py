"""Natural frequency, bandwidth and step metrics against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.plant import (
    bandwidth_hz,
    natural_frequency_hz,
    resonance_db,
    step_metrics,
)


@pytest.mark.parametrize("xi", [0.1, 0.5, 0.7071, 1.0, 3.0])
def test_bandwidth_and_resonance_are_those_of_the_response(xi: float) -> None:
    T = 0.0078

    def gain_db(frequency_hz: float) -> float:
        s = 2j * np.pi * frequency_hz
        return float(-20.0 * np.log10(abs(T * T * s * s + 2.0 * xi * T * s + 1.0)))

    assert gain_db(bandwidth_hz(T, xi)) == pytest.approx(-10.0 * np.log10(2.0), abs=1e-9)
    grid = np.linspace(0.0, 3.0 * natural_frequency_hz(T), 20_001)
    assert resonance_db(xi) == pytest.approx(max(gain_db(f) for f in grid), abs=1e-5)


@pytest.mark.parametrize("xi", [0.2, 0.5, 0.8])
def test_step_metrics_of_a_second_order_system(xi: float) -> None:
    """Overshoot and response: Ogata, Modern Control Engineering, 5th ed., section 5.3."""
    t = np.linspace(0.0, 60.0, 60_001)
    w = np.sqrt(1.0 - xi * xi)
    angle = 1.0 - np.exp(-xi * t) * (np.cos(w * t) + xi / w * np.sin(w * t))
    found = step_metrics(t, 3.0 + 5.0 * angle)
    assert found.final_deg == pytest.approx(8.0, abs=1e-3)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * xi / w), abs=1e-4)
    assert found.rise_s is not None
    assert found.settling_s is not None
    inside = np.abs(angle - 1.0) <= 0.02
    assert found.settling_s == pytest.approx(t[~inside][-1], abs=0.01)
    low, high = (t[np.argmax(angle >= level)] for level in (0.1, 0.9))
    assert found.rise_s == pytest.approx(high - low, abs=0.003)


def test_a_response_that_does_not_get_there_has_no_times() -> None:
    t = np.linspace(0.0, 1.0, 101)
    found = step_metrics(t, np.zeros(101))
    assert (found.rise_s, found.settling_s, found.overshoot) == (None, None, 0.0)
    still_moving = step_metrics(t, t)
    assert still_moving.rise_s == pytest.approx(0.8)
    assert still_moving.settling_s == pytest.approx(0.98, abs=0.011)
