"""How much of an error repeats where the command does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from servosight.diagnose.evidence import Repeated, Scatter, repeated, run_floor, run_scatter
from servosight.diagnose.residuals import FIT, Judged
from servosight.diagnose.result.wording import Levels
from servosight.diagnose.selection import AcceptanceCriterion
from servosight.models.core import Array, Recording

TIME_S = np.arange(0.0, 10.0, 0.01)


def case(error_deg: Array, command_hz: float, name: str = "run") -> Judged:
    command = 10.0 * np.sin(2.0 * np.pi * command_hz * TIME_S)
    recording = Recording(name, TIME_S, command, TIME_S, command + error_deg, hold="linear")
    return Judged(recording, command, np.full(TIME_S.size, FIT, dtype=np.int8))


def noise(seed: int, size_deg: float = 0.1) -> Array:
    return np.asarray(size_deg * np.random.default_rng(seed).normal(size=TIME_S.size))


def found_in(*judged: Judged) -> Repeated:
    found = repeated(judged)
    assert found is not None
    return found


def test_periods_part_an_error_into_what_repeats_and_what_does_not() -> None:
    same = 0.3 * np.cos(2.0 * np.pi * 0.5 * TIME_S)
    found = found_in(case(same + noise(1), 0.5))
    assert (found.kind, found.count, found.recordings) == ("periods", 4, ("run",))
    assert found.scatter_deg == pytest.approx(0.1, rel=0.05)
    assert found.repeating_deg == pytest.approx(0.3 / np.sqrt(2.0), rel=0.05)
    assert found.share == pytest.approx(0.045 / 0.055, abs=0.03)
    assert f"{100.0 * found.share:.0f} % repeats" in found.sentence


def test_noise_alone_does_not_repeat() -> None:
    found = found_in(case(noise(2), 0.5))
    assert found.share < 0.1
    assert found.scatter_deg == pytest.approx(0.1, rel=0.05)


def test_runs_with_the_same_command_are_compared() -> None:
    """The command itself is never repeated within a run; the clocks begin elsewhere."""
    same = 0.3 * np.cos(1.3 * TIME_S)
    first = case(same + noise(3), 0.04, "first")
    second = case(same + noise(4), 0.04, "second")
    moved = second.recording
    moved = replace(moved, time_s=moved.time_s + 7.0, command_time_s=moved.command_time_s + 7.0)
    found = found_in(first, replace(second, recording=moved))
    assert (found.kind, found.count) == ("runs", 2)
    assert found.recordings == ("first", "second")
    assert found.scatter_deg == pytest.approx(0.1, rel=0.1)
    assert found.share == pytest.approx(0.045 / 0.055, abs=0.05)


def test_other_commands_gains_and_loads_are_not_compared() -> None:
    first = case(noise(3), 0.04, "first")
    assert repeated([first]) is None
    assert repeated([first, case(noise(4), 0.05, "second")]) is None
    other = replace(first, recording=replace(first.recording, relative_load=2.0))
    assert repeated([first, other]) is None


def again(error_deg: Array, name: str, moved_s: float = 0.0) -> Recording:
    """A servo that follows by 0.9 with a lag; its run begins ``moved_s`` late."""
    angle = 9.0 * np.sin(2.0 * np.pi * 0.04 * (TIME_S - 0.1 + moved_s)) + error_deg
    command = 10.0 * np.sin(2.0 * np.pi * 0.04 * (TIME_S + moved_s))
    return Recording(name, TIME_S, command, TIME_S, angle, hold="linear")


def test_the_scatter_from_run_to_run_is_that_of_the_servo() -> None:
    """Friction that lets go elsewhere each time; mean, and a start 20 ms apart, do not count."""
    wander = [0.05 * np.sin(0.7 * TIME_S + phase) for phase in (0.0, 2.1, 4.2)]
    runs = [
        again(one + noise(5 + n, 0.01) + n, f"run {n}", 0.01 * n) for n, one in enumerate(wander)
    ]
    expected = np.hypot(0.05 / np.sqrt(2.0), 0.01)
    found = run_scatter(runs)
    assert found is not None
    assert found.rms_deg == pytest.approx(expected * np.sqrt(1.5), rel=0.2)
    floor, (words,) = run_floor(runs)
    assert floor == found
    assert words.startswith("run 0, run 1, run 2 have the same command and differ by 0.0")


def test_few_repeats_and_changed_conditions_are_no_floor() -> None:
    first, second = again(noise(1, 0.01), "a"), again(noise(2, 0.01), "b")
    long = replace(first, name="c", command_deg=-first.command_deg)
    assert run_scatter([first]) is None
    assert run_scatter([first, second, long]) is not None
    more = [replace(long, relative_gain=gain) for gain in (1.0, 2.0, 3.0)]
    assert run_scatter([first, second, *more]) is None
    floor, (words,) = run_floor([first, replace(second, angle_deg=0.8 * second.angle_deg)])
    assert floor is None
    assert "what was changed between them?" in words
    assert run_floor([first]) == (None, [])
    assert run_floor([first, replace(first, name="copy")]) == (None, [])


def test_the_words_name_the_scatter_where_it_is_the_floor() -> None:
    for scatter, said, floor in ((0.2, "scatter from run to run", 0.2), (0.05, "noise", 0.1)):
        levels = Levels(noise_deg=0.1, tolerance_deg=0.01, floor_deg=floor, scatter_deg=scatter)
        assert f"({said} " in levels.words(1.0)
        assert ("scatter of the servo" in levels.words(floor)) == (scatter > 0.1)


def wandering(seed: int, share: float) -> Array:
    """0.1 deg rms, a share of the sample before in each: independent with 0, (samples,)."""
    steps = noise(seed, 0.1 * float(np.sqrt(1.0 - share**2)))
    steps[0] = noise(seed, 0.1)[0]
    return np.asarray(lfilter([1.0], [1.0, -share], steps))


def scatter_of(share: float, seed: int) -> Scatter:
    runs = [again(wandering(2 * seed + n, share), f"run {n}") for n in range(2)]
    found = run_scatter(runs)
    assert found is not None
    return found


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_a_sample_is_worth_less_where_what_differs_is_autocorrelated(share: float) -> None:
    """The squares of a first-order process: one over the sum of share^2|lag| over all lags."""
    exact = (1.0 - share**2) / (1.0 + share**2)
    found = [scatter_of(share, seed) for seed in range(20)]
    assert np.mean([one.worth for one in found]) == pytest.approx(exact, rel=0.15)
    assert np.mean([one.freedom for one in found]) == pytest.approx(exact * TIME_S.size, rel=0.15)


def test_a_run_like_the_others_is_above_their_floor_by_chance_only() -> None:
    """1 in 100 by chance: of 400 more than 12 with a probability of 1e-4. 10 % is far too little:
    two runs of 10 s, independent every 0.2 s, tell the floor to some 10 %."""
    above, crude = 0, 0
    for seed in range(400):
        scatter = scatter_of(0.9, seed)
        criterion = AcceptanceCriterion(
            scatter.rms_deg, 0.0, worth=scatter.worth, freedom=scatter.freedom
        )
        rmse = float(np.std(wandering(10_000 + seed, 0.9)))
        above += not criterion.at_floor(rmse, TIME_S.size)
        crude += not AcceptanceCriterion(scatter.rms_deg, 0.0).at_floor(rmse, TIME_S.size)
    assert above <= 12
    assert crude >= 40
