"""What the tests of an error conclude by chance, and from which samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from support.made_errors import RATE_HZ, case, found_in

from servosight.diagnose.residuals import (
    FIT,
    TEST,
    VALIDATION,
    Judged,
    held_out_samples,
    independence,
    linear_share,
    quantile,
    whiteness,
)
from servosight.models.excitation import Excitation, chirp


@pytest.mark.parametrize("gaps", [False, True])
def test_whiteness_is_a_chi_square(gaps: bool) -> None:
    """p of white errors is uniform, missing samples or not (Kolmogorov and Smirnov, 1 % level)."""
    chances = []
    for seed in range(60):
        times = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
        if gaps:
            times = times[np.random.default_rng(seed).uniform(size=times.size) > 0.2]
        chances.append(whiteness(held_out_samples([case(seed=seed, times=times)])).p)
    steps = np.arange(1, 61) / 60
    assert np.max(np.abs(np.sort(chances) - steps)) < 1.63 / np.sqrt(60)


def coloured(pole: float, seed: int) -> Judged:
    """All samples for the test, with errors e_t = pole e_(t-1) + v_t, v of 0.1 deg."""
    judged = case(noise_deg=0.0)
    recording = judged.recording
    drive = np.random.default_rng(seed).normal(0.0, 0.1, recording.time_s.size)
    error_deg = lfilter([1.0], [1.0, -pole], drive)
    return replace(
        judged,
        recording=replace(recording, angle_deg=recording.angle_deg + error_deg),
        uses=np.full(recording.time_s.size, TEST, dtype=np.int8),
    )


def test_the_autocorrelation_is_the_process_own() -> None:
    """e_t = 0.8 e_(t-1) + v_t has the autocorrelation 0.8^lag."""
    found = whiteness(held_out_samples([coloured(0.8, seed=3)]))
    # Bartlett: the standard error of these is below sqrt((1 + 0.64) / (1 - 0.64) / 2400) = 0.044.
    np.testing.assert_allclose(found.value[:4], 0.8 ** np.arange(1, 5), atol=3 * 0.044)


def test_the_band_of_independence_holds_what_it_says() -> None:
    """Coloured errors against a coloured command: 95 % of all values within the 95 % band."""
    inside = []
    for seed in range(40):
        found = independence(held_out_samples([coloured(0.9, seed)]))
        inside.append(np.mean(np.abs(found.value) < quantile(0.95) * found.sigma))
    # Lags of a recording hang together: 40 recordings give about +-0.05.
    assert np.mean(inside) == pytest.approx(0.95, abs=0.06)


def test_a_late_answer_follows_the_command() -> None:
    """The answer comes 10 ms later than the model's: linear, and more lag at high frequency."""
    found = found_in(case(lambda t, y: np.interp(t - 0.01, t, y) - y))
    assert found["command"].share > 0.5
    assert "linearity" not in found
    assert "more lag" in found["frequency"].sentence


def test_a_late_answer_to_a_chirp_is_linear() -> None:
    """Each second has a frequency of its own: none tells how the others would be filtered."""
    time_s = np.arange(0.0, 8.0, 0.01)
    gentle = Excitation(time_s, chirp(time_s, 6.0, 0.3, 5.0))
    judged = case(lambda t, y: np.interp(t - 0.01, t, y) - y, excitation=gentle)
    assert linear_share(held_out_samples([judged])) > 0.8
    assert "linearity" not in found_in(judged)


def test_only_held_out_samples_are_judged() -> None:
    judged = case()
    spoilt = judged.recording.angle_deg + 5.0 * judged.fitted
    recording = replace(judged.recording, angle_deg=spoilt)
    (one,) = held_out_samples([replace(judged, recording=recording)])
    assert np.array_equal(one.scored, judged.uses == TEST)
    # A filter of 24 taps removes about 24 of the samples' squares by chance.
    assert linear_share([one]) < 2.0 * 24 / one.scored.sum()
    assert whiteness([one]).p > 1e-3
    # A recording that was fitted as a whole does not count beside one that was not.
    seen = replace(judged, uses=np.full_like(judged.uses, FIT))
    fresh = replace(judged, uses=np.full_like(judged.uses, TEST))
    assert len(held_out_samples([seen, fresh])) == 1


def test_the_test_alone_is_judged_where_it_has_four_samples_for_each_lag() -> None:
    """0.5 s of lags at 120 Hz are 60 samples: 240 are needed, otherwise validation counts too."""
    judged = case()
    for count, alone in ((240, True), (239, False)):
        uses = np.full_like(judged.uses, FIT)
        uses[:500] = VALIDATION
        uses[500 : 500 + count] = TEST
        (one,) = held_out_samples([replace(judged, uses=uses)])
        assert int(one.scored.sum()) == (count if alone else 500 + count)
