"""The hidden-effect benchmark: its trials, its counting, and a small part of itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hidden import score
from hidden.draw import (
    ADDED,
    DURATION_S,
    NOISE_DEG,
    ROWS,
    choice,
    choices,
    noise_for,
    propose,
)
from hidden.page import page
from hidden.pictures import pictures
from hidden.run import Results, run_trials
from hidden.trial import Fits, NoDraw, find_facts, run_trial
from servosight.scenarios.sweeps.run import Store, WatchLimits, run_batch


@pytest.mark.parametrize("row", ROWS)
def test_a_trial_is_drawn_from_its_seed_alone(row: str) -> None:
    one, other, next_one = propose(row, 5, 0), propose(row, 5, 0), propose(row, 6, 0)
    assert np.array_equal(one.excitation.command_deg, other.excitation.command_deg)
    assert (one.servo, one.effects, one.camera) == (other.servo, other.effects, other.camera)
    assert one.servo != next_one.servo
    assert len(one.effects) == ROWS[row].hidden
    assert DURATION_S[0] - 0.1 <= one.excitation.duration_s <= DURATION_S[1] + 0.1


def first_count(row: str) -> int:
    """How many sets the seeds take turns through: those without effects that came later."""
    return sum(not set(ADDED) & set(names) for names in choices(row))


def test_every_effect_takes_its_turn() -> None:
    """Of 600 seeds each of the sets has about its share, and the first ones their old seeds."""
    sets, first = choices("single"), first_count("single")
    drawn = [choice("single", seed)[0] for seed in range(600)]
    mean = len(drawn) / len(sets)
    counts = [drawn.count(names) for names in sets]
    assert 0.4 * mean < min(counts) <= max(counts) < 2.0 * mean
    moved = [names for seed, names in enumerate(drawn) if names != sets[seed % first]]
    assert {name for names in moved for name in names} == set(ADDED)
    truths = {propose("single", seed, 0).truth for seed in (0, first)}
    assert truths == {"twin", "fixed steps"}


@pytest.mark.parametrize("row", ["single", "weak", "faint", "coarse"])
def test_the_noise_gives_the_strength_that_the_row_asks_for(row: str) -> None:
    low, high = ROWS[row].strength
    for seed in range(20):
        setup = propose(row, seed, 0)
        noise = noise_for(setup, 0.4)
        if noise is not None:
            assert NOISE_DEG[0] <= noise <= NOISE_DEG[1]
            assert low <= 0.4 / noise * (1 + 1e-12)
            assert 0.4 / noise <= high * (1 + 1e-12)
    assert noise_for(propose(row, 0, 0), 1e-4) is None


def seed_of(effect: str) -> int:
    """The first seed that hides an effect in the plain fixed steps."""
    mine = (seed for seed in range(1000) if choice("single", seed)[0] == (effect,))
    return next(seed for seed in mine if propose("single", seed, 0).truth == "fixed steps")


def test_fits_know_the_misfit_of_a_set_and_of_its_parts() -> None:
    """The truth by fixed steps, without noise: only numerics remain, below 0.002 deg."""
    setup = propose("single", seed_of("dead_zone"), 0)
    fits = Fits(setup.record(0.0))
    assert fits.misfit_deg(("dead_zone",)) < 0.002
    assert fits.misfit_deg(()) > 10.0 * fits.misfit_deg(("dead_zone",))
    assert set(fits.known) == {"", "dead_zone"}


def test_a_pair_that_no_twin_has_at_once_is_no_draw() -> None:
    pair = ("flexible_shaft", "feedback_backlash")
    mine = (seed for seed in range(5000) if choice("pair", seed)[0] == pair)
    seed = next(seed for seed in mine if propose("pair", seed, 0).truth == "twin")
    with pytest.raises(NoDraw, match="flexible_shaft and feedback_backlash cannot be simulated"):
        find_facts("pair", seed)


def line(**changes: Any) -> dict[str, Any]:
    """A trial as a results file holds it: backlash hidden and named."""
    facts = {
        "truth": "twin", "hidden": {"backlash": {"gap": 1.0}}, "strength": 9.0, "cost": 500.0,
        "rival": "dead_zone", "misfit_deg": {"dead_zone": 0.2}, "own_deg": 0.001, "noise_deg": 0.03,
        "with_sigma": True, "rate_hz": 120.0, "duration_s": 12.0, "servo": {"T": 0.02, "xi": 0.6},
    }  # fmt: skip
    facts |= changes.pop("facts", {})
    return {
        "row": "single", "seed": 1, "facts": facts, "named": ["backlash"], "verdict": "explained",
        "group": ["backlash"], "alternatives": [], "noise_found_deg": 0.03, "floor_deg": 0.036,
        "over_floor": 0.9,
        "parameters": {"k": [1.0, 1.001, 0.0008], "backlash.gap": [1.0, 1.06, 0.01]},
        "candidates": [["backlash", 0.03, 900.0]], "ladder": [[None, None, 0.3]], "cpu_s": 2.0,
        **changes,
    }  # fmt: skip


def test_what_counts_as_right() -> None:
    assert score.right(line())
    wrong = line(named=["dead_zone"])
    assert not score.right(wrong)
    vague = line(named=["dead_zone"], facts={"cost": 3.0}, group=["dead_zone", "backlash"])
    assert score.right(vague)
    assert not score.right({**vague, "group": ["dead_zone"]})
    assert score.right(line(row="nothing", facts={"hidden": {}}, named=[]))
    assert not score.right(line(row="nothing", facts={"hidden": {}}))
    # Outside the catalogue: a name on the way is forgiven by `right`, but not by `named`.
    outside = line(row="outside", facts={"hidden": {"gust": {}}}, verdict="unexplained")
    assert score.right(outside)
    assert not score.named(outside)
    assert not score.right({**outside, "verdict": "explained"})


def test_parameters_are_counted_against_their_sigma_or_their_size() -> None:
    within = [score.close(*numbers) for _, *numbers in score.parameters([line()])]
    assert within == [True, False]  # 6 % and six sigma off
    assert score.parameters([line(named=[])]) == []


def test_wilson_gives_the_published_interval() -> None:
    """Newcombe, Statistics in Medicine 17 (1998), table I: 81 of 263."""
    low, high = score.Share(81, 263).interval
    assert low == pytest.approx(0.2553, abs=5e-5)
    assert high == pytest.approx(0.3662, abs=5e-5)
    assert score.Share(0, 0).interval == (0.0, 1.0)
    assert score.Share(300, 300).interval[0] > 0.98


def test_results_of_other_sources_are_not_mixed_in(tmp_path: Path) -> None:
    store = Store(tmp_path / "out")
    results = Results(store, "new", "same")
    assert results.lines() == []
    with store.opened({}):
        for seed, version, made in ((1, "old", "same"), (2, "new", "same"), (3, "old", "other")):
            task = Results(store, version, made).task(("single", seed), None)
            text = {"line": json.dumps(line(seed=seed))}
            run_batch(lambda _, text=text: text, [task], str(store.cells), WatchLimits())
        (store.cells / "4.json.1-aa").write_text('{"line')  # a run that was cut short
    assert [one["seed"] for one in results.lines()] == [2]
    assert set(results.facts()) == {("single", 1), ("single", 2)}


def test_a_trial_that_is_there_is_not_run_again(tmp_path: Path) -> None:
    results = Results(Store(tmp_path / "out"), "new", "same")
    jobs = [("single", seed) for seed in range(3)]
    with results.store.opened({}):
        for job in jobs:
            text = {"line": json.dumps(line(seed=job[1]))}
            task = results.task(job, None)
            run_batch(lambda _, text=text: text, [task], str(results.store.cells), WatchLimits())
    found = run_trials(results, jobs[::-1], 1, lambda *_: pytest.fail("nothing is to be run"))
    assert [one["seed"] for one in found] == [2, 1, 0]
    assert {one["version"] for one in found} == {"new"}


def test_a_half_done_run_can_be_drawn(tmp_path: Path) -> None:
    lines = [line(seed=1), line(seed=2, named=["dead_zone"])]
    text = page(lines, "make hidden")
    assert "| 50.0 % | 9.5 to 90.5 % | 2 | twin 1 of 2 |" in text
    assert "| single | backlash | dead_zone (explained) | 1 |" in text
    assert "from 0 trials" in page([], "make hidden")
    pictures(lines, tmp_path)
    assert sorted(path.stem for path in tmp_path.iterdir()) == [
        "confusion", "detection", "parameters", "time",
    ]  # fmt: skip
    assert "--only 2" in score.explain(lines[1])


@pytest.mark.parametrize("row", ["single", "nothing"])
def test_a_trial_comes_out_right(row: str) -> None:
    """Strength 3 at least, separable: the goal is 99 of 100, so a single trial must do."""
    found = run_trial(row, seed_of("dead_zone"))
    print(score.explain(found))
    low, high = ROWS[row].strength
    assert low <= found["facts"]["strength"] <= high
    assert score.separable(found)
    assert score.right(found)
    json.dumps(found, allow_nan=False)
