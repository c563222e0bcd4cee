"""What is found in errors made by hand: each names its own, none names noise."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from support.made_errors import NOISE_DEG, RATE_HZ, case, direction, found_in

from servosight.diagnose.residuals import Judged, findings, lead
from servosight.models.core import Array, Signals


def test_noise_is_no_finding() -> None:
    for seed in range(40):
        judged = case(seed=seed)
        assert findings([judged], NOISE_DEG, NOISE_DEG) == ()
    assert "no test finds a systematic error" in lead([judged], (), NOISE_DEG)


def test_coloured_noise_does_not_follow_the_command() -> None:
    """An autoregression of 0.9: not white, and nothing else, in 40 recordings.

    Six tests with a chance of 0.01 each, and sizes that matter: 2.4 expected at the very most.
    """
    named: list[str] = []
    for seed in range(40):
        judged = case(seed=seed)
        drive = np.random.default_rng(1000 + seed).normal(0.0, 0.1, judged.recording.time_s.size)
        measured = judged.recording.angle_deg + lfilter([1.0], [1.0, -0.9], drive)
        judged = replace(judged, recording=replace(judged.recording, angle_deg=measured))
        named += [one.test for one in findings([judged], NOISE_DEG, NOISE_DEG)]
    located = [name for name in named if name not in ("whiteness", "linearity")]
    assert named.count("whiteness") == 40
    assert len(located) <= 6, located


def test_one_way_worse_than_the_other() -> None:
    wave = lambda t: np.sin(2.0 * np.pi * 11.0 * t)  # noqa: E731
    found = found_in(case(lambda t, y: 0.5 * wave(t) * (direction(t, y) > 0.0)))
    assert "while the angle rises" in found["direction"].sentence


def test_an_error_that_drifts() -> None:
    found = found_in(case(lambda t, y: 0.03 * t))
    assert "drifts, from +0.0" in found["time"].sentence


def pushed(judged: Judged, size_n: float) -> Judged:
    """With a force of ``size_n`` in the log, in pulses of 0.2 s once a second."""
    time_s = judged.recording.time_s
    force = size_n * (np.modf(time_s)[0] < 0.2)
    signals = Signals(time_s, {"disturbance_N": force})
    return replace(judged, recording=replace(judged.recording, signals=signals))


def test_what_a_known_disturbance_moves_is_told_apart() -> None:
    """A force of 20 N gives way by 0.30 deg with a lag of 50 ms; the model has no such input."""
    lag = np.exp(-1.0 / (0.05 * RATE_HZ))

    def moved(t: Array, y: Array) -> Array:
        force = 20.0 * (np.modf(t)[0] < 0.2)
        return np.asarray(lfilter([0.015 * (1.0 - lag)], [1.0, -lag], force))

    found = found_in(pushed(case(moved), 20.0))["disturbance"]
    assert found.share > 0.8
    own = moved(np.arange(0.0, 9.0, 1.0 / RATE_HZ), np.zeros(0))
    assert found.size_deg == pytest.approx(np.std(own), rel=0.2)
    assert "(up to 20.0 N) can account for" in found.sentence
    assert "disturbance" not in found_in(case(moved))


def test_a_force_that_moves_nothing_is_no_finding() -> None:
    for error in (direction, lambda t, y: 0.3 * np.sin(2.0 * np.pi * 0.31 * t)):
        assert "disturbance" not in found_in(pushed(case(error), 20.0))


def test_uneven_and_missing_samples() -> None:
    """Frames that come when they like, a fifth lost and a gap of 3 s: the same findings."""
    rng = np.random.default_rng(5)
    times = np.arange(0.0, 20.0, 1.0 / RATE_HZ) + rng.uniform(-0.002, 0.002, 2400)
    times = times[(rng.uniform(size=2400) > 0.2) & ((times < 11.0) | (times > 14.0))]
    found = found_in(case(lambda t, y: -0.3 * direction(t, y), times=times))
    assert "lags the model by 0.30 deg" in found["speed"].sentence
    assert findings([case(times=times)], NOISE_DEG, NOISE_DEG) == ()


def test_it_takes_no_time() -> None:
    """20 s at 120 Hz in less than 0.3 s of processor time."""
    judged = case(lambda t, y: -0.3 * direction(t, y))
    findings([judged], NOISE_DEG, NOISE_DEG)
    began = time.process_time()
    findings([judged], NOISE_DEG, NOISE_DEG)
    assert time.process_time() - began < 0.3


@pytest.mark.parametrize("count", [50, 60, 130])
def test_short_recordings(count: int) -> None:
    judged = case(lambda t, y: -0.3 * direction(t, y), times=np.arange(count) / 30.0)
    for one in findings([judged], NOISE_DEG, NOISE_DEG):
        assert np.isfinite([one.size_deg, one.share, one.p]).all()


def test_large_numbers_have_no_exponent_and_all_have_units() -> None:
    """An error of some 150 deg that depends on where the surface stands."""
    (judged,) = [case(lambda t, y: 15.0 * y)]
    found = found_in(judged)
    assert not [one.sentence for one in found.values() if "e+" in one.sentence]
    assert found["angle"].sentence.count(" deg near ") == 2
    assert found["angle"].sentence.endswith(" deg.")
