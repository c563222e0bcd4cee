"""Long recordings: which stretches of them a selection sees, and what a diagnosis says of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.diagnose import Diagnosis, PriorKnowledge, diagnose, predictions
from servosight.diagnose.residuals import TEST, rms
from servosight.diagnose.selection import cut, stretches
from servosight.identify.problem import Problem
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus

ALONE = PriorKnowledge(without_effects=tuple(set(catalogue()) - {"backlash"}))
"""Only backlash to choose from; the kernel is that of the whole catalogue, compiled before."""
DURATION_S = 92.0
ROWS = 10_000
POINT = [1.0, np.log(0.02), np.log(0.7), 0.6, 0.5]
"""k, T, xi, gap and bias."""


def logged(name: str, seed: int) -> Recording:
    """92 s with play, whose angle starts a clock of its own: 34,000 rows in all."""
    excitation = standard(DURATION_S, 20.0, seed=seed)
    time_s = 0.004 + np.arange(int(120 * DURATION_S)) / 120.0
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[:5] = 1.0, 0.02, 0.7, 0.5, 0.5
    row[plant.index("backlash.gap")] = 0.6
    stimulus = Stimulus(excitation.time_s, excitation.command_deg, False, time_s, np.ones(1))
    noise = np.random.default_rng(1).normal(0.0, 0.03, time_s.size)
    angle = plant.simulate(row, stimulus) + noise
    return Recording(name, excitation.time_s, excitation.command_deg, time_s, angle)


@pytest.fixture(scope="module")
def log() -> Recording:
    return logged("log", 5)


def test_ordinary_recordings_stay_whole(log: Recording) -> None:
    assert stretches([log, log]) == ([(), ()], [])
    assert cut(log, ()) == [log]


def test_what_is_rare_is_covered() -> None:
    """A servo that hardly moves but for one swing, and one fast one."""
    time_s = np.arange(0.0, 600.0, 0.01)
    angle = np.sin(time_s)
    angle[20_000:20_800] += 30.0 * np.sin(np.linspace(0.0, np.pi, 800)) ** 2
    angle[43_000:43_200] += 10.0 * np.sin(np.linspace(0.0, 6.0 * np.pi, 200))
    idle = Recording("idle", time_s, angle, time_s, angle)
    (spans,), (note,) = stretches([idle], 8_000)
    assert len(spans) == 3
    for middle in (204.0, 431.0):
        assert any(start + 1.0 <= middle <= end for start, end in spans)
    assert note.startswith("idle: too long to try models on all of it: 3 stretches of 12 s are")
    assert "by a factor of 4.1 at most" in note
    assert "`servosight identify`" in note


@pytest.mark.parametrize(("at_s", "first_s"), [(3.0, 0.0), (50.0, 48.0)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_swing_is_covered_to_either_side(at_s: float, first_s: float, sign: float) -> None:
    """In the first stretch as in another."""
    time_s = np.arange(0.0, 97.0, 0.02)
    swing = 15.0 - 15.0 * np.cos(2.0 * np.pi * (time_s - at_s) / 8.0)
    angle = np.sin(time_s) + sign * np.where((time_s > at_s) & (time_s < at_s + 8.0), swing, 0.0)
    assert stretches([Recording("a", time_s, angle, time_s, angle)], 2_000)[0] == [
        ((first_s, first_s + 13.0),)
    ]


def test_few_reversals_count_as_much_as_many_angles() -> None:
    """A stretch of small zigzags at the usual speed, among sweeps that cover every angle."""
    time_s = np.arange(0.0, 121.0, 0.01)
    zigzag = (time_s >= 61.0) & (time_s < 73.0)
    upward = np.where(
        zigzag, (time_s - 61.0) % 1.2 < np.where(time_s < 67.0, 0.66, 0.54), time_s % 6.0 < 3.0
    )
    angle = 0.04 * np.cumsum(np.where(upward, 1.0, -1.0))
    angle -= angle.mean()
    found, _ = stretches([Recording("a", time_s, angle, time_s, angle)], 2_000)
    assert found == [((60.0, 73.0),)]


@pytest.mark.parametrize(("duration_s", "whole"), [(24.9, True), (25.1, False)])
def test_a_recording_of_one_stretch_stays_whole(duration_s: float, whole: bool) -> None:
    """One second of lead and twelve that are scored; a second stretch begins behind these."""
    time_s = np.arange(0.0, duration_s, 0.01)
    found, _ = stretches([Recording("a", time_s, np.sin(time_s), time_s, np.sin(time_s))], 300)
    assert (found == [()]) is whole


def test_a_stretch_keeps_the_uncertainty_of_its_samples() -> None:
    time_s = np.arange(0.0, 20.0, 1.0 / 64.0)
    run = Recording("run", time_s, time_s, time_s, time_s, sigma_deg=0.01 + time_s)
    (part,) = cut(replace(run, shared_deg=0.02 + time_s), ((4.0, 8.0),))
    np.testing.assert_array_equal(part.sigma_deg, 0.01 + part.time_s)
    np.testing.assert_array_equal(part.shared_deg, 0.02 + part.time_s)


@pytest.mark.parametrize(("scale", "offset_deg", "later_s"), [(1e3, 0, 0), (1, 50, 0), (1, 0, 512)])
def test_units_and_zeros_choose_nothing(scale: float, offset_deg: float, later_s: float) -> None:
    """The same stretches in millidegrees, from another zero of the angle, on another clock."""
    rng = np.random.default_rng(2)
    time_s = np.arange(0.0, 400.0, 0.02)
    angle = np.sin(time_s) * np.interp(time_s, np.arange(0, 401, 20), rng.uniform(0.1, 9, 21))
    (spans,), _ = stretches([Recording("a", time_s, angle, time_s, angle)], 8_000)
    other = time_s + later_s, offset_deg + scale * angle
    (found,), _ = stretches([Recording("b", *other, *other)], 8_000)
    assert len(spans) == 6
    np.testing.assert_allclose(found, np.add(spans, later_s), atol=1e-6)


@pytest.mark.parametrize(("hold", "whole"), [("zero", True), ("linear", False)])
def test_rows_that_repeat_a_command_cost_nothing(hold: Any, whole: bool) -> None:
    """4,000 rows of two levels held: two rows to a simulation, unless it interpolates."""
    command_s, time_s = 0.025 * np.arange(4_000), 0.25 * np.arange(400)
    command = np.where(command_s < 50.0, 0.0, 5.0)
    run = Recording("run", command_s, command, time_s, np.sin(time_s), hold=hold)
    (spans,), _ = stretches([run], 402)
    assert (spans == ()) is whole
    if whole:
        assert stretches([run], 401)[0] != [()]


def test_a_stretch_keeps_its_first_samples_and_those_behind_the_lead() -> None:
    """And the command rows from the one that holds two seconds before to the first after it."""
    time_s = np.arange(0.0, 20.0, 1.0 / 64.0)
    command_s = np.arange(0.25, 20.0, 0.5)
    (part,) = cut(Recording("run", command_s, command_s, time_s, time_s), ((4.0, 8.0),))
    expected = np.concatenate([4.0 + np.arange(10) / 64.0, np.arange(5.0, 8.0 + 1e-9, 1.0 / 64.0)])
    np.testing.assert_array_equal(part.time_s, expected)
    assert (part.command_time_s[0], part.command_time_s[-1]) == (1.75, 8.25)
    (first,) = cut(Recording("run", command_s, command_s, time_s, time_s), ((0.0, 8.0),))
    assert first.command_time_s[0] == 0.25


def test_the_shortest_keep_what_they_have(log: Recording) -> None:
    short = cut(log, ((30.0, 43.0),))[0]
    (few, many), notes = stretches([short, log], ROWS)
    assert few == ()
    assert len(many) >= 1
    assert len(notes) == 1


def test_a_stretch_is_simulated_as_within_the_whole(log: Recording) -> None:
    """The play has forgotten where it began when the scored samples begin."""
    whole = Problem.of([log], catalogue(), ["backlash"])
    expected = whole.predict(np.array([*POINT, 0.5, 0.0]))[0][0]
    (part,) = cut(log, ((40.0, 53.0),))
    assert part.command_time_s[0] < 40.0 <= part.time_s[0]
    stretch = Problem.of([part], catalogue(), ["backlash"])
    found = stretch.predict(np.array([*POINT, part.angle_deg[0], 0.0]))[0][0]
    same = np.isin(log.time_s, part.time_s)
    behind = part.time_s >= 41.0
    np.testing.assert_allclose(found[behind], expected[same][behind], atol=1e-6)


def test_a_diagnosis_of_long_recordings(log: Recording, tmp_path: Path) -> None:
    """Times stay those of the log, one recording stays one, and its models are drawn again."""
    given = [log, logged("other", 6)]
    found = diagnose(given[:1], test=given[1:], prior=ALONE, most_rows=ROWS)
    starts = [warning.split(" to try")[0] for warning in found.warnings]
    assert starts == ["log: too long", "other: too long"]
    assert [(use.name, use.role) for use in found.recordings] == [
        ("log", "split"),
        ("other", "test"),
    ]
    assert [len(use.stretches_s) for use in found.recordings] == [1, 1]
    assert [one.recording for one in found.ladder[0].own] == ["log", "other"]
    assert found.candidates[0].effect == "backlash"
    assert found.actuator.provenance["fitted_on"] == ["log"]
    spans = {use.name: use.stretches_s[0] for use in found.recordings}
    for window in found.where:
        start, end = spans[window.recording]
        assert start <= window.start_s < window.end_s <= end

    found.save(tmp_path / "diagnosis.json")
    back = Diagnosis.load(tmp_path / "diagnosis.json")
    assert back == found
    judged = predictions(back, given, 0, catalogue=catalogue())
    assert rms([one.errors_of(TEST) for one in judged]) == pytest.approx(
        found.ladder[0].held_out_rmse_deg, rel=1e-9
    )
    start, end = spans["log"]
    assert found.recordings[0].parts == (f"log, {start:.0f} to {end:.0f} s",)
