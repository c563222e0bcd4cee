"""The diagnosis through diagnose(): its JSON, its steps and its words."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.vocabulary import WHATS

from servosight.diagnose import Diagnosis, diagnose, predictions
from servosight.diagnose.change import change_between
from servosight.diagnose.residuals import TEST
from servosight.diagnose.result.wording import Levels
from servosight.diagnose.selection import ModelSelection, PriorKnowledge, Split
from servosight.models.base import json_text
from servosight.models.core import Actuator, InputError, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus


@pytest.fixture(scope="module")
def found(diagnosed: Any) -> Any:
    """Backlash, diagnosed to the end."""
    return diagnosed("backlash")


def test_a_weight_that_all_but_falls_over_does_not_stand_for_what_is_missing(twin: Any) -> None:
    """A rubber stop: free to cancel the loop's stiffness, a weight fits best with a k of 0.07."""
    recording, truth = twin("end_stop", seed=3, duration_s=20.0)
    bench = ModelSelection(Split.of([recording]), catalogue())
    fit = bench.extended(bench.linear(), "gravity_load").fit
    assert fit.problem.values(fit.outcome.point)["k"] == pytest.approx(bench.ranges["k"][0])
    assert 0.15 * truth["k"] < bench.ranges["k"][0] < truth["k"] < bench.ranges["k"][1]


def test_k_keeps_its_sign_and_a_share_of_the_gain_that_is_shown(twin: Any) -> None:
    recording, _ = twin("backlash")
    turned = replace(recording, angle_deg=-recording.angle_deg)
    bench = ModelSelection(Split.of([turned]), catalogue())
    low, high = bench.ranges["k"]
    assert low == -10.0
    assert -1.0 < high < 0.0
    assert bench.linear().fit.problem.ranges["k"] == (low, high)


def test_json_to_the_letter(found: Any) -> None:
    """Keys, types and vocabulary of the fixed interface; json refuses NaN and Infinity."""
    answer = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert answer["schema"] == 1
    assert answer["verdict"] == "explained"
    assert answer["effects"] == ["backlash"]
    assert isinstance(answer["next_experiment"], str)
    assert answer["floor_deg"] == pytest.approx(
        math.hypot(answer["noise_deg"], found.tolerance_deg)
    )

    for step in answer["ladder"]:
        assert step.keys() >= {
            "added",
            "effects",
            "train_rmse_deg",
            "validation_rmse_deg",
            "held_out_rmse_deg",
            "explained",
            "parameters",
        }
        assert isinstance(step["explained"], bool)
        assert step["explained"] == (step["held_out_rmse_deg"] <= 1.10 * answer["floor_deg"])
        assert step["parameters"].keys() >= {"k", "T", "xi", "bias"}
        for one in step["parameters"].values():
            assert one.keys() == {"value", "sigma", "unit"}
            assert isinstance(one["value"], float)
            assert one["sigma"] is None or one["sigma"] > 0.0
    first, last = answer["ladder"][0], answer["ladder"][-1]
    assert (first["added"], first["effects"], first["explained"]) == (None, [], False)
    assert (last["added"], last["effects"], last["explained"]) == ("backlash", ["backlash"], True)
    assert last["parameters"]["backlash.gap"]["unit"] == "deg"

    offered = set(catalogue()) - {"known_disturbance"}  # the recording has none
    assert {one["effect"] for one in answer["candidates"]} == offered
    for one in answer["candidates"]:
        assert one.keys() >= {"effect", "held_out_rmse_deg", "evidence", "confounded_with"}
        assert set(one["confounded_with"]) <= offered - {one["effect"]}
    evidence = [one["evidence"] for one in answer["candidates"]]
    assert evidence == sorted(evidence, reverse=True)

    assert answer["where"]
    for one in answer["where"]:
        assert one.keys() >= {"recording", "start_s", "end_s", "rmse_deg", "share", "what"}
        assert one["recording"] == "backlash"
        assert one["start_s"] < one["end_s"]
        assert 0.0 < one["share"] <= 1.0
        assert one["what"] in WHATS
    share = [one["share"] for one in answer["where"]]
    assert share == sorted(share, reverse=True)
    assert sum(share) <= 1.0 + 1e-9


def test_without_auto_the_ladder_has_one_entry(found: Any, twin: Any) -> None:
    """The verdict speaks of the linear model; ranking and first step are those of the climb."""
    first = diagnose([twin("backlash")[0]], catalogue=catalogue())
    assert len(first.ladder) == 1
    assert first.effects == ()
    assert first.verdict == "unexplained"
    assert first.actuator.effects == ()
    assert first.candidates == found.candidates
    assert json_text(first.ladder[0]) == json_text(found.ladder[0])
    assert "servosight add" in first.next_experiment
    assert "backlash" in first.next_experiment


def test_a_diagnosis_is_a_value(found: Any, twin: Any, tmp_path: Path) -> None:
    """What is saved is read back equal, and its models predict what they did."""
    recording = twin("backlash")[0]
    found.save(tmp_path / "diagnosis.json")
    back = Diagnosis.load(tmp_path / "diagnosis.json")
    assert back == found
    for step, one in enumerate(found.ladder):
        (judged,) = predictions(back, [recording], step)
        errors = judged.error_deg[judged.uses == TEST]
        assert np.sqrt(np.mean(errors**2)) == pytest.approx(one.held_out_rmse_deg, rel=1e-9)
    with pytest.raises(InputError, match="expected those of the diagnosis"):
        predictions(back, [replace(recording, name="another")])


def test_a_card_keeps_the_covariance(found: Any, tmp_path: Path) -> None:
    """Read back, it gives the bandwidth the sigma that the diagnosis has: of T and xi, to 1 %."""
    found.actuator.save(tmp_path / "model.toml")
    card = Actuator.load(tmp_path / "model.toml")
    last = found.ladder[-1]
    for name, row in zip(last.covariance.names, last.covariance.values, strict=True):
        place = last.covariance.names.index(name)
        assert np.sqrt(row[place]) == pytest.approx(last.parameters[name].sigma)
    read = change_between(card, card, catalogue=catalogue()).a.dynamics
    assert read is not None
    assert read.bandwidth_hz.value == pytest.approx(last.dynamics.bandwidth_hz.value)
    assert read.bandwidth_hz.sigma == pytest.approx(last.dynamics.bandwidth_hz.sigma, rel=0.01)
    assert read.rise_time_s is not None
    assert read.rise_time_s.sigma > 0.0  # type: ignore[operator]
    held = replace(last.parameters["k"], sigma=0.0)
    step = replace(last, parameters={**last.parameters, "k": held})
    at = step.covariance.names.index("k")
    assert not step.covariance.values[at].any()


def test_words_tell_noise_from_tolerance(found: Any) -> None:
    """An error far below the floor is said to be so, where that is only a tolerance."""
    levels = Levels(noise_deg=0.0003, tolerance_deg=0.0224, floor_deg=0.0224)
    assert levels.words(0.0003) == (
        "far below the tolerance of 0.0224 deg at which the search ends; the noise of the "
        "measurement is 0.000300 deg"
    )
    assert levels.words(0.02).startswith("within the tolerance of 0.0224 deg at which")
    assert levels.words(0.1) == (
        "4.5 times the floor of 0.0224 deg (noise 0.000300 deg and tolerance 0.0224 deg together)"
    )
    noisy = Levels(noise_deg=0.03, tolerance_deg=0.01, floor_deg=0.0316)
    assert (
        noisy.words(0.03) == "no more than the noise of the measurement, 0.0300 deg, accounts for"
    )
    assert found.headline == "What was missing: backlash"


def test_the_tolerance_decides_what_counts(twin: Any, few: PriorKnowledge) -> None:
    """With 2 deg of tolerance nothing is missing; the default is 0.05 % of the moved range."""
    recording, _ = twin("backlash", duration_s=6.0)
    loose = diagnose([recording], prior=few, auto=True, tolerance=2.0)
    assert loose.verdict == "no_effect_missing"
    assert loose.effects == ()
    assert loose.floor_deg == pytest.approx(math.hypot(0.03, 2.0))
    usual = diagnose([recording], prior=few)
    assert usual.tolerance_deg == pytest.approx(5e-4 * recording.moved_range_deg)


def test_progress_is_told(twin: Any, few: PriorKnowledge) -> None:
    told: list[tuple[str, int, int]] = []
    diagnose([twin("backlash")[0]], prior=few, progress=lambda *line: told.append(line))
    assert any("backlash" in text for text, _, _ in told)
    assert all(0 <= done <= total for _, done, total in told)


def test_look_alikes_on_a_single_amplitude_are_confounded(few: PriorKnowledge) -> None:
    """A slow triangle of one amplitude: play and dry friction give the same lag at every reversal.

    Truth: the plant with a gap of 1 deg. The wrong one must be named beside the right one.
    """
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.02, 0.7
    row[plant.index("backlash.gap")] = 1.0
    time_s = np.arange(0.0, 8.0, 0.004)
    command = 15.0 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * 0.25 * time_s))
    samples = 0.002 + np.arange(940) / 120.0
    angle = plant.simulate(row, Stimulus(time_s, command, False, samples, np.ones(1)))
    noise = np.random.default_rng(1).normal(0.0, 0.05, samples.size)
    recording = Recording("triangle", time_s, command, samples, angle + noise)
    found = diagnose([recording], prior=few)
    groups = {one.effect: set(one.confounded_with) for one in found.candidates}
    print(groups)
    assert found.candidates[0].effect in {"backlash", "coulomb_friction", "dead_zone"}
    assert groups["backlash"] & {"coulomb_friction", "dead_zone"}
    for one, others in groups.items():
        assert all(one in groups[other] for other in others)
    best = found.candidates[0]
    if best.confounded_with:
        assert found.proposal is not None
        assert {(name,) for name in best.confounded_with} <= set(found.alternatives)
        assert found.next_experiment == found.proposal.sentence
        assert np.ptp(found.proposal.excitation.command_deg) <= np.ptp(command) + 1e-9
