"""What the tests of an error find, on errors made by hand: each names its own, none names noise."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import freqz, lfilter

from servosight.diagnose.residuals import (
    FIT,
    TEST,
    VALIDATION,
    Finding,
    Judged,
    all_samples,
    findings,
    held_out_samples,
    independence,
    lead,
    linear_share,
    profile,
    quantile,
    response,
    swings,
    turning_points,
    turns,
    whiteness,
)
from servosight.diagnose.residuals._events import rests
from servosight.diagnose.selection import Split
from servosight.models.core import Array, Recording, Signals
from servosight.models.excitation import CommandLimits, Excitation, chirp, design

NOISE_DEG = 0.03
RATE_HZ = 120.0
STEP_S = 0.001
STANDARD = design("standard", CommandLimits(20.0, None, 20.0)).excitation


def servo_filter() -> tuple[list[float], list[float]]:
    """G(s) = 1 / (0.03^2 s^2 + 2 0.7 0.03 s + 1) by implicit steps of 1 ms, as a filter."""
    # y[n] - 2 y[n-1] + y[n-2] + b (y[n] - y[n-1]) + a^2 y[n] = a^2 u[n].
    a, b = STEP_S / 0.03, 2.0 * 0.7 * STEP_S / 0.03
    scale = 1.0 + b + a**2
    return [a**2 / scale], [1.0, -(2.0 + b) / scale, 1.0 / scale]


def servo(excitation: Excitation, time_s: Array) -> Array:
    """The angle at ``time_s`` for the held command."""
    fine = np.arange(0.0, time_s[-1] + 2.0 * STEP_S, STEP_S)
    rows = np.searchsorted(excitation.time_s, fine + 1e-9, side="right") - 1
    return np.interp(time_s, fine, lfilter(*servo_filter(), excitation.command_deg[rows]))


def case(
    error: Callable[[Array, Array], Array] = lambda t, y: np.zeros_like(t),
    *,
    seed: int = 0,
    excitation: Excitation = STANDARD,
    times: Array | None = None,
    noise_deg: float = NOISE_DEG,
) -> Judged:
    """A linear servo whose measured angle is off by ``error(time, angle)`` and white noise."""
    time_s = np.arange(0.0, excitation.time_s[-1], 1.0 / RATE_HZ) if times is None else times
    angle = servo(excitation, time_s)
    noise = np.random.default_rng(seed).normal(0.0, noise_deg, time_s.size)
    measured = angle + error(time_s, angle) + noise
    recording = Recording("made", excitation.time_s, excitation.command_deg, time_s, measured)
    return Judged(recording, angle, Split.of([recording]).uses[0])


def direction(t: Array, y: Array) -> Array:
    speed = np.gradient(y, t)
    return np.asarray(np.sign(speed) * (np.abs(speed) > 1.0))


def found_in(judged: Judged) -> dict[str, Finding]:
    return {one.test: one for one in findings([judged], NOISE_DEG, NOISE_DEG)}


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


def test_the_autocorrelation_is_the_process_own() -> None:
    """e_t = 0.8 e_(t-1) + v_t has the autocorrelation 0.8^lag."""
    judged = case(noise_deg=0.0)
    drive = np.random.default_rng(3).normal(0.0, 0.1, judged.recording.time_s.size)
    recording = judged.recording
    coloured = recording.angle_deg + lfilter([1.0], [1.0, -0.8], drive)
    one = replace(
        judged,
        recording=replace(recording, angle_deg=coloured),
        uses=np.full(recording.time_s.size, TEST, dtype=np.int8),
    )
    found = whiteness(held_out_samples([one]))
    # Bartlett: the standard error of these is below sqrt((1 + 0.64) / (1 - 0.64) / 2400) = 0.044.
    np.testing.assert_allclose(found.value[:4], 0.8 ** np.arange(1, 5), atol=3 * 0.044)


def test_the_band_of_independence_holds_what_it_says() -> None:
    """Coloured errors against a coloured command: 95 % of all values within the 95 % band."""
    inside = []
    for seed in range(40):
        judged = case(noise_deg=0.0)
        recording = judged.recording
        drive = np.random.default_rng(seed).normal(0.0, 0.1, recording.time_s.size)
        coloured = recording.angle_deg + lfilter([1.0], [1.0, -0.9], drive)
        one = replace(
            judged,
            recording=replace(recording, angle_deg=coloured),
            uses=np.full(recording.time_s.size, TEST, dtype=np.int8),
        )
        found = independence(held_out_samples([one]))
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


def test_friction_lags_at_any_speed() -> None:
    """Behind by 0.3 deg whichever way it moves: share and size come from the error itself."""
    judged = case(lambda t, y: -0.3 * direction(t, y))
    found = found_in(judged)
    assert "lags the model by 0.3 deg, at any speed" in found["speed"].sentence
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


def test_one_way_worse_than_the_other() -> None:
    wave = lambda t: np.sin(2.0 * np.pi * 11.0 * t)  # noqa: E731
    found = found_in(case(lambda t, y: 0.5 * wave(t) * (direction(t, y) > 0.0)))
    assert "while the angle rises" in found["direction"].sentence


def test_an_error_that_drifts() -> None:
    found = found_in(case(lambda t, y: 0.03 * t))
    assert "drifts, from +0.0" in found["time"].sentence


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


def pushed(judged: Judged, size_n: float) -> Judged:
    """With a force of ``size_n`` in the log, in pulses of 0.2 s once a second."""
    time_s = judged.recording.time_s
    force = size_n * (np.modf(time_s)[0] < 0.2)
    signals = Signals(time_s, {"disturbance_N": force})
    return replace(judged, recording=replace(judged.recording, signals=signals))


def test_what_a_known_disturbance_moves_is_told_apart() -> None:
    """A force of 20 N gives way by 0.3 deg with a lag of 50 ms; the model has no such input."""
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
    assert "0.2 deg short of" in found_in(judged)["standstill"].sentence


def test_turning_points_are_those_of_the_motion() -> None:
    t = np.linspace(0.0, 4.0, 801)
    points = turning_points(np.sin(2.0 * np.pi * 1.0 * t) + 0.01 * np.sin(2.0 * np.pi * 40.0 * t))
    np.testing.assert_allclose(t[points], 0.25 + 0.5 * np.arange(8), atol=0.02)
    assert turning_points(np.zeros(50)).size == 0


def test_the_response_of_a_known_servo() -> None:
    """A model with 1.1 times the gain: apart from that they agree within three sigma."""
    judged = case()
    found = response([replace(judged, predicted_deg=1.1 * judged.predicted_deg)])
    assert found is not None
    off = np.abs(found.measured - found.model / 1.1) / found.sigma
    assert np.mean(off < 3.0) > 0.97
    strong = found.power_deg2 > 0.01 * found.power_deg2.max()
    np.testing.assert_allclose(np.abs(found.model / found.measured)[strong], 1.1, rtol=0.02)
    assert np.all(found.coherence[strong] > 0.95)


def test_the_response_at_the_lines_of_a_multisine() -> None:
    """The made servo's own response to a command held for 1 ms, within three sigma."""
    rows = design("multisine", CommandLimits(15.0, None, 20.0), seed=2).excitation
    found = response([case(excitation=rows)])
    assert found is not None
    top, bottom = servo_filter()
    turns = 2.0 * np.pi * found.frequency_hz * STEP_S
    exact = np.abs(np.asarray(freqz(top, bottom, turns)[1]))
    off = np.abs(np.abs(found.measured) - exact)
    # The rest is the straight line between the made servo's steps: (w step)^2 / 12 at most.
    assert np.all(off < 3.0 * found.sigma + turns**2 * exact)


def test_distortion_is_shown_where_the_command_tells_it() -> None:
    rows = design("multisine", CommandLimits(15.0, None, 20.0), seed=2).excitation
    found = found_in(case(lambda t, y: 0.01 * y**2, excitation=rows))
    assert "Even distortion" in found["distortion"].sentence
    assert found["distortion"].p < 1e-3
    assert "distortion" not in found_in(case(excitation=rows))


def test_several_recordings_are_named_and_weighed() -> None:
    """A late answer beside a calm recording: its square counts for its share of the samples."""
    late = case(lambda t, y: np.interp(t - 0.01, t, y) - y)
    rows = design("multisine", CommandLimits(15.0, None, 18.0), seed=2).excitation
    calm = case(excitation=rows)
    both = findings([late, calm], NOISE_DEG, NOISE_DEG)
    found = {one.test: one for one in both}["frequency"]
    assert found.sentence.startswith("On made: near ")
    alone = response([late])
    assert alone is not None
    counts = [one.recording.time_s.size for one in (late, calm)]
    part = np.sqrt(np.sum(alone.misfit_deg2) * counts[0] / sum(counts))
    assert found.size_deg == pytest.approx(part, rel=1e-6)


def test_uneven_and_missing_samples() -> None:
    """Frames that come when they like, a fifth lost and a gap of 3 s: the same findings."""
    rng = np.random.default_rng(5)
    times = np.arange(0.0, 20.0, 1.0 / RATE_HZ) + rng.uniform(-0.002, 0.002, 2400)
    times = times[(rng.uniform(size=2400) > 0.2) & ((times < 11.0) | (times > 14.0))]
    found = found_in(case(lambda t, y: -0.3 * direction(t, y), times=times))
    assert "lags the model by 0.3 deg" in found["speed"].sentence
    assert findings([case(times=times)], NOISE_DEG, NOISE_DEG) == ()


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
