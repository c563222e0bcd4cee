"""The coded light read from synthetic brightness: integrated over exposures, noisy, jittered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from servosight.bench.light import BIT_S
from servosight.bench.timing import LightPattern, block_means, decode, even_stamps, find_light
from servosight.models.core import Array, InputError

DARK, BRIGHT, NOISE = 30.0, 180.0, 2.0


@dataclass(frozen=True)
class Filmed:
    """Frames of the light: stamps by the camera's clock, true mid-exposure times, brightness."""

    stamps_s: Array
    mid_s: Array
    level: Array
    pattern: LightPattern
    exposure_s: float
    offset_s: float
    drift: float

    @property
    def bound(self) -> Array:
        """Cramer-Rao bound of the offset in the middle [s] and of the drift, levels unknown."""
        step, passed = 1e-6, self.mid_s - self.mid_s.mean()
        change = [
            self.pattern.share(self.mid_s + step * by, self.exposure_s)
            - self.pattern.share(self.mid_s - step * by, self.exposure_s)
            for by in (np.ones_like(passed), passed)
        ]
        columns = [(BRIGHT - DARK) * one / (2 * step) for one in change]
        columns += [np.ones_like(passed), self.pattern.share(self.mid_s, self.exposure_s)]
        jacobian = np.column_stack(columns) / NOISE
        return np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))[:2])


def filmed(
    seed: int,
    *,
    duration_s: float = 8.0,
    rate_hz: float = 60.0,
    exposure_s: float = 0.004,
    jitter_s: float = 0.0,
    lost: float = 0.03,
) -> Filmed:
    """A camera of its own clock films the light; ``jitter_s`` is that of its stamps."""
    rng = np.random.default_rng(seed)
    offset_s, drift = rng.uniform(-0.7, 0.7), rng.uniform(-1e-4, 1e-4)
    pattern = LightPattern.of_command(1.0, duration_s - 0.4)
    mid_s = rng.uniform(0.0, 1.0 / rate_hz) + np.arange(0.0, duration_s, 1.0 / rate_hz)
    mid_s = mid_s[rng.random(mid_s.size) >= lost]
    # mid = middle + offset + (1 + drift)(stamp - middle), the middle between first and last stamp
    middle_s = 0.5 * (mid_s[0] + mid_s[-1]) - offset_s
    stamps_s = middle_s + (mid_s - offset_s - middle_s) / (1.0 + drift)
    level = DARK + (BRIGHT - DARK) * pattern.share(mid_s, exposure_s)
    level = level + NOISE * rng.standard_normal(mid_s.size)
    stamps_s = stamps_s + jitter_s * rng.uniform(-1.0, 1.0, mid_s.size)
    return Filmed(stamps_s, mid_s, level, pattern, exposure_s, offset_s, drift)


def test_offset_and_drift_reach_the_bound_and_know_their_uncertainty() -> None:
    offsets, drifts, worst = [], [], 0.0
    for seed in range(20):
        film = filmed(seed)
        fit = decode(film.stamps_s, film.level, film.pattern, exposure_s=film.exposure_s)
        bound = film.bound
        offsets.append(((fit.offset_s - film.offset_s) / bound[0], fit.offset_sigma_s / bound[0]))
        drifts.append(((fit.drift - film.drift) / bound[1], fit.drift_sigma / bound[1]))
        worst = max(worst, float(np.abs(fit.mid_exposure(film.stamps_s) - film.mid_s).max()))
    for pairs in (offsets, drifts):
        error, sigma = np.array(pairs).T
        assert np.sqrt(np.mean(error**2)) < 1.4  # 20 draws scatter by a sixth
        assert np.sqrt(np.mean((error / sigma) ** 2)) < 1.4
        assert np.median(sigma) < 1.5
    assert worst < 1e-3  # what the bench promises at 60 frames a second


def test_drift_is_right_to_ten_ppm_over_a_minute() -> None:
    film = filmed(3, duration_s=60.0)
    fit = decode(film.stamps_s, film.level, film.pattern, exposure_s=film.exposure_s)
    assert abs(fit.drift - film.drift) < 1e-6 + 3.0 * film.bound[1]
    assert fit.drift_sigma < 1e-5
    assert np.abs(fit.mid_exposure(film.stamps_s) - film.mid_s).max() < 1e-4


def test_the_exposure_is_found_where_it_is_not_given() -> None:
    for seed in range(6):
        film = filmed(seed)
        fit = decode(film.stamps_s, film.level, film.pattern)
        assert fit.exposure_s == pytest.approx(film.exposure_s, abs=1e-3)
        assert abs(fit.offset_s - film.offset_s) < 3.0 * fit.offset_sigma_s
        assert np.abs(fit.mid_exposure(film.stamps_s) - film.mid_s).max() < 1e-3


@pytest.mark.parametrize("frames_a_bit", [1, 2])
def test_where_no_exposure_contains_a_switching_the_gap_between_exposures_is_the_sigma(
    frames_a_bit: int,
) -> None:
    # Where a bit lasts whole frames, all switchings lie at one phase of the frames.
    rate_hz = frames_a_bit / BIT_S
    errors = []
    for seed in range(8):
        film = filmed(seed, rate_hz=rate_hz, exposure_s=2e-4, lost=0.0, duration_s=5.0)
        fit = decode(film.stamps_s, film.level, film.pattern, exposure_s=film.exposure_s)
        errors.append((fit.offset_s - film.offset_s) / fit.offset_sigma_s)
    assert np.sqrt(np.mean(np.square(errors))) < 1.5  # evenly spread over the gap: at most 1.73
    assert np.abs(errors).max() < 2.0


@pytest.mark.parametrize("rate_hz", [25.0, 30.0, 50.0, 60.0, 100.0, 120.0])
def test_at_the_usual_rates_a_short_exposure_is_enough(rate_hz: float) -> None:
    film = filmed(6, rate_hz=rate_hz, exposure_s=1e-3, lost=0.0)
    fit = decode(film.stamps_s, film.level, film.pattern, exposure_s=film.exposure_s)
    assert abs(fit.offset_s - film.offset_s) < 5e-4
    assert fit.offset_sigma_s < 5e-4


def test_jitter_of_the_stamps_widens_the_uncertainty() -> None:
    errors = []
    for seed in range(10):
        film = filmed(seed, jitter_s=1e-3)
        fit = decode(film.stamps_s, film.level, film.pattern, exposure_s=film.exposure_s)
        errors.append((fit.offset_s - film.offset_s, fit.offset_sigma_s))
    error, sigma = np.array(errors).T
    assert np.abs(error).max() < 1e-3
    assert np.sqrt(np.mean((error / sigma) ** 2)) < 1.6


def test_jitter_of_an_even_rate_is_removed_across_lost_frames() -> None:
    film = filmed(1, jitter_s=3e-3, lost=0.1)
    even = even_stamps(film.stamps_s)
    assert np.std(np.diff(even - film.mid_s)) < 1e-5
    rng = np.random.default_rng(0)
    free = np.cumsum(rng.uniform(0.005, 0.03, 200))
    np.testing.assert_array_equal(even_stamps(free), free)


def test_brightness_that_follows_no_code_is_refused() -> None:
    film = filmed(2)
    noise = np.random.default_rng(9).standard_normal(film.level.size)
    with pytest.raises(InputError, match="correlation"):
        decode(film.stamps_s, noise, film.pattern)
    with pytest.raises(InputError, match="at least 30"):
        decode(film.stamps_s[:20], film.level[:20], film.pattern)


def test_the_light_is_found_in_the_picture_beside_what_moves() -> None:
    film = filmed(4, duration_s=6.0)
    rng = np.random.default_rng(4)
    share = (film.level - DARK) / (BRIGHT - DARK)
    frames = []
    for n, part in enumerate(share):
        image = 60.0 + 3.0 * rng.standard_normal((120, 160))
        x = 60 + int(40 * np.sin(0.2 * n))
        image[40:80, x : x + 20] += 120.0  # a surface that turns
        image[20:32, 120:132] += 140.0 * part
        frames.append(block_means(np.clip(image, 0, 255).astype(np.uint8)))
    seen = find_light(film.stamps_s, np.array(frames), film.pattern)
    assert seen is not None
    assert seen.place_px == pytest.approx((125.5, 25.5), abs=3.0)
    fit = decode(film.stamps_s, seen.level, film.pattern, guess_s=seen.offset_s, reach_s=0.05)
    assert np.abs(fit.mid_exposure(film.stamps_s) - film.mid_s).max() < 1e-3
    dark = np.array(frames)
    dark[:, 2:5, 14:18] = 60.0
    assert find_light(film.stamps_s, dark, film.pattern) is None
