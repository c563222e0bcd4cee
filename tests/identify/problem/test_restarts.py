"""The measured motion with which a prediction over a horizon begins anew."""

from __future__ import annotations

from typing import Any

import numpy as np

from servosight.identify.problem import Problem
from servosight.identify.problem._restarts import restarts
from servosight.models.core import Recording
from servosight.models.effects import catalogue


def parabola(rate_hz: float = 100.0) -> Recording:
    """Angle, speed and acceleration 2, 3 and 4 in deg and s."""
    time_s = np.arange(0.0, 3.0, 1.0 / rate_hz)
    angle = 2.0 + 3.0 * time_s + 2.0 * time_s**2
    return Recording("run", time_s, angle, time_s, angle)


def test_angle_and_speed_of_a_parabola_are_exact() -> None:
    recording = parabola()
    found = restarts(recording, np.ones(recording.time_s.size, dtype=bool), 0.25)
    times, angles, speeds = found
    np.testing.assert_allclose(times[:10], 0.25 * np.arange(1, 11), atol=0.011)
    np.testing.assert_allclose(angles, 2.0 + 3.0 * times + 2.0 * times**2, atol=1e-9)
    np.testing.assert_allclose(speeds[:-1], 3.0 + 4.0 * times[:-1], atol=1e-9)


def test_samples_that_are_not_scored_tell_nothing() -> None:
    """An error of 90 deg on them changes nothing, and no restart stands within three samples."""
    recording = parabola()
    scored = (recording.time_s < 1.0) | (recording.time_s > 2.0)
    spoilt = Recording(
        "run",
        recording.time_s,
        recording.angle_deg + 90.0 * ~scored,
        recording.time_s,
        recording.command_deg,
    )
    found = restarts(spoilt, scored, 0.1)
    np.testing.assert_array_equal(found, restarts(recording, scored, 0.1))
    assert not np.any((found[0] > 0.97) & (found[0] < 2.03))


def test_samples_too_rare_for_the_horizon_give_no_restart() -> None:
    rare = parabola(rate_hz=20.0)
    every = np.ones(rare.time_s.size, dtype=bool)
    assert restarts(rare, every, 0.25).shape == (3, 0)
    assert restarts(rare, every, 0.5).shape[1] > 0


def test_a_prediction_over_a_horizon_forgets_a_wrong_start(record: Any) -> None:
    """With k off by 5 %, the error of a prediction over two T is that of so short a time."""
    recording = record(6.0, noise_deg=0.001, k=1.0, T=0.05, xi=0.7)
    whole = Problem.of([recording], catalogue(), ())
    near = Problem.of([recording], catalogue(), (), horizon_s=0.1)
    point = np.array([1.05, np.log(0.05), np.log(0.7), 0.0, recording.angle_deg[0], 0.0])

    def rms(problem: Problem) -> float:
        return float(np.sqrt(np.mean(problem.residuals(point[None, :]) ** 2)))

    assert rms(near) < 0.5 * rms(whole)
