"""The noise estimator against noise that is known.

Bounds are three standard deviations of the error measured over 40 noises, see docs/accuracy.md:
2.5 % for 12 s at 120 frames a second (1.9 % is the limit of 1440 samples whose true angle is
known), 5 % for 20 s at 30.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.identify.problem import joint_noise_deg, noise_deg
from servosight.identify.problem.noise._noise import resolution_deg
from servosight.models.io.importers import Request, import_recording

BOUND = 0.08


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("T", [0.0078, 0.03])
def test_white_noise(seed: int, T: float, record: Any) -> None:
    assert noise_deg(record(20.0, seed, 0.03, T=T)) == pytest.approx(0.03, rel=BOUND)


@pytest.mark.parametrize("noise", [0.003, 0.3])
def test_small_and_large_noise(noise: float, record: Any) -> None:
    assert noise_deg(record(12.0, 5, noise)) == pytest.approx(noise, rel=BOUND)


def test_noise_is_right_on_average(record: Any) -> None:
    """20 noises: their mean is known to 2.5 % / sqrt(20) = 0.6 %, and their scatter to a sixth."""
    whole = record(12.0, noise_deg=0.0)
    found = []
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 0.03, whole.time_s.size)
        found.append(noise_deg(replace(whole, angle_deg=whole.angle_deg + noise)))
    off = np.array(found) / 0.03 - 1.0
    print(f"mean {off.mean():.4f}, rms {np.sqrt(np.mean(off**2)):.4f}")
    assert abs(off.mean()) < 0.02
    assert np.sqrt(np.mean(off**2)) < 0.05


def test_a_step_that_is_over_between_two_frames_does_not_count(record: Any) -> None:
    """30 frames a second and T = 7.8 ms: the first frame after a step is a surprise."""
    time_s = 0.004 + np.arange(599) / 30.0
    assert noise_deg(record(20.0, 1, 0.03, time_s=time_s)) == pytest.approx(0.03, rel=0.15)


@pytest.mark.parametrize("rate_hz", [30.0, 120.0])
def test_a_command_that_repeats_itself_tells_noise_at_any_frame_rate(
    rate_hz: float, record: Any
) -> None:
    """12 periods: 330 differences at 30 frames a second, known to 3.9 %; at 120 to 1.9 %."""
    time_s = 0.004 + np.arange(int(12 * rate_hz) - 1) / rate_hz
    found = noise_deg(record(12.0, 2, 0.03, kind="sine", time_s=time_s))
    assert found == pytest.approx(0.03, rel=3.0 / np.sqrt(2.0 * 11.0 * rate_hz))


@pytest.mark.parametrize(
    "effect",
    [
        {"backlash__gap": 1.5},
        {"coulomb_friction__level": 0.9},
        {"dead_zone__half_width": 1.0},
        {"rate_limit__rate": 200.0},
    ],
    ids=lambda effect: next(iter(effect)).partition("__")[0],
)
def test_what_a_linear_model_misses_is_no_noise(effect: dict[str, float], record: Any) -> None:
    """The error of the best linear model is 3 to 20 times this noise."""
    assert noise_deg(record(20.0, 3, 0.03, **effect)) == pytest.approx(0.03, rel=BOUND)


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


def test_an_encoder_with_noise_of_its_own(record: Any) -> None:
    """Noise of 0.6 steps and the grid's: their squares add."""
    step = 360 / 4096
    recording = record(20.0, 1, noise_deg=0.6 * step)
    grid = step * np.round(recording.angle_deg / step)
    expected = np.hypot(0.6 * step, step / np.sqrt(12))
    assert noise_deg(replace(recording, angle_deg=grid)) == pytest.approx(expected, rel=BOUND)


def test_resolution() -> None:
    angle = 0.088 * np.round(np.random.default_rng(0).normal(0, 3, 3000) / 0.088)
    assert resolution_deg(angle) == pytest.approx(0.088)
    assert resolution_deg(np.random.default_rng(0).normal(0, 3, 3000)) == 0.0
    assert resolution_deg(np.zeros(5)) == 0.0


def test_a_short_log_of_a_fine_grid_is_on_it() -> None:
    """Hardly any angle comes twice, as in a fast log of a servo that never stands still."""
    angle = 0.088 * np.round(np.linspace(0.0, 1.0, 300) ** 2 * 90.0 / 0.088)
    assert resolution_deg(angle) == pytest.approx(0.088)


def test_several_recordings_join_by_their_squares(record: Any) -> None:
    one, other = (replace(record(2.0), sigma_deg=np.full(240, sigma)) for sigma in (0.03, 0.04))
    assert joint_noise_deg((one, other)) == pytest.approx(np.sqrt((0.03**2 + 0.04**2) / 2))


@pytest.mark.parametrize("log", ["sin_sin_kp100", "sin_sin_kp400", "up_and_down_kp200"])
def test_a_real_encoder(log: str, real_data: Path) -> None:
    """XL330, 4096 counts a turn: a count's rounding, and not much beyond it."""
    recording = import_recording(real_data / "xl330" / f"{log}.json", Request())
    count = 360 / 4096
    assert resolution_deg(recording.angle_deg) == pytest.approx(count)
    assert count / np.sqrt(12) <= noise_deg(recording) * (1 + 1e-9)
    assert noise_deg(recording) < 2.0 * count / np.sqrt(12)
