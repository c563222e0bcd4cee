"""The noise estimator against noise that is known.

Bound 10 % for 20 s at 120 Hz: the calm third holds about 800 samples, whose own scatter is
1 / sqrt(2 * 800) = 2.5 %, correlated by the differences to about 4 %; the rest is margin for what
the servo's motion leaks.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.noise import (
    divided_differences,
    joint_noise_deg,
    noise_deg,
    resolution_deg,
)

BOUND = 0.10


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("T", [0.0078, 0.03])
def test_white_noise(seed: int, T: float, record: Any) -> None:
    assert noise_deg(record(20.0, seed, 0.03, T=T)) == pytest.approx(0.03, rel=BOUND)


def test_jittered_times(record: Any) -> None:
    rng = np.random.default_rng(3)
    time_s = 0.01 + np.arange(2390) / 120.0 + rng.uniform(-0.003, 0.003, 2390)
    assert noise_deg(record(20.0, 1, 0.03, time_s=time_s)) == pytest.approx(0.03, rel=BOUND)


def test_dropped_frames(record: Any) -> None:
    """One frame in ten is missing."""
    rng = np.random.default_rng(4)
    time_s = 0.004 + np.flatnonzero(rng.random(2390) > 0.1) / 120.0
    assert noise_deg(record(20.0, 2, 0.03, time_s=time_s)) == pytest.approx(0.03, rel=BOUND)


def test_noise_that_is_given_is_the_noise(record: Any) -> None:
    """Rms of the sigmas: sqrt((0.1^2 + 0.2^2) / 2)."""
    recording = record(2.0)
    sigma = np.where(np.arange(recording.time_s.size) % 2, 0.1, 0.2)
    assert noise_deg(replace(recording, sigma_deg=sigma)) == pytest.approx(np.sqrt(0.025))


@pytest.mark.parametrize("step", [360 / 4096, 0.25])
def test_an_encoder_is_no_better_than_its_grid(step: float, record: Any) -> None:
    """No noise but the grid's: at least step / sqrt(12), and not twice that."""
    recording = record(10.0, noise_deg=0.0)
    grid = step * np.round(recording.angle_deg / step)
    found = noise_deg(replace(recording, angle_deg=grid))
    assert step / np.sqrt(12) <= found * (1 + 1e-9)
    assert found < 2.0 * step / np.sqrt(12)


def test_resolution() -> None:
    angle = 0.088 * np.round(np.random.default_rng(0).normal(0, 3, 3000) / 0.088)
    assert resolution_deg(angle) == pytest.approx(0.088)
    assert resolution_deg(np.random.default_rng(0).normal(0, 3, 3000)) == 0.0
    assert resolution_deg(np.zeros(5)) == 0.0


def test_several_recordings_join_by_their_squares(record: Any) -> None:
    one, other = (replace(record(2.0), sigma_deg=np.full(240, sigma)) for sigma in (0.03, 0.04))
    assert joint_noise_deg((one, other)) == pytest.approx(np.sqrt((0.03**2 + 0.04**2) / 2))


@pytest.mark.parametrize("order", [3, 4, 6])
def test_divided_differences_remove_polynomials_and_keep_the_noise(order: int) -> None:
    rng = np.random.default_rng(order)
    time_s = np.cumsum(rng.uniform(0.005, 0.012, 20_000))
    smooth = np.polyval(rng.normal(size=order), (time_s - 80.0) / 80.0)
    assert np.abs(divided_differences(time_s, smooth, order)).max() < 1e-9
    noise = divided_differences(time_s, rng.normal(0.0, 1.0, time_s.size), order)
    assert noise.std() == pytest.approx(1.0, rel=0.05)
