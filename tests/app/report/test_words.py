"""What a report says of the model: verdicts, law, findings, regimes, the next experiment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.page import Page
from support.reports import written

from servosight.app.report.sections.selection import ladder
from servosight.app.report.sections.selection.candidates import groups
from servosight.diagnose import Comparison, Diagnosis, Verdict
from servosight.diagnose.evidence import Regime
from servosight.diagnose.experiment import Proposal, Separation
from servosight.diagnose.result.wording import Levels, verdict_words
from servosight.models.core import Recording, Table
from servosight.models.excitation import CommandLimits, design


@pytest.mark.usefixtures("unpainted")
def test_verdicts_in_words(tmp_path: Path, found: Diagnosis, recording: Recording) -> None:
    one, levels = found.ladder[:1], Levels(noise_deg=0.02, tolerance_deg=0.015, floor_deg=0.025)
    ranked = verdict_words(Verdict.UNEXPLAINED, one, found.candidates, None, levels)
    assert "backlash alone has the most evidence" in ranked[1]
    assert (
        "the floor of 0.0250 deg (noise 0.0200 deg and tolerance 0.0150 deg together)" in ranked[1]
    )
    nothing = verdict_words(Verdict.NO_EFFECT_MISSING, one, found.candidates, None, levels)
    assert nothing[0] == "No effect is missing"
    close = replace(levels, floor_deg=0.5 * found.ladder[-1].held_out_rmse_deg)
    part = verdict_words(Verdict.UNEXPLAINED, found.ladder, found.candidates, None, close)
    assert part[0] == "Not fully explained"
    assert "something remains that no known effect accounts for" in part[1]
    held = replace(found.ladder[-1], held=("k held at 1 from here, 0.93 before",))
    steps = Table([*found.ladder[:-1], held])
    result = replace(
        found, verdict=Verdict.UNEXPLAINED, headline=part[0], summary=part[1], ladder=steps
    )
    _, page = written(tmp_path / "part.html", result, [recording])
    assert "+ backlash: k held at 1 from here, 0.93 before." in page.text
    assert part[0] in page.text
    assert " ".join(part[1].split()) in page.text
    assert "What the error of the model with backlash shows: " in page.text
    rivals = Table(replace(c, confounded_with=("dead_zone",)) for c in found.candidates[:1])
    doubt = replace(found, candidates=rivals, alternatives=(("dead_zone",), ("presliding",)))
    _, page = written(tmp_path / "doubt.html", doubt, [recording])
    said = "cannot distinguish backlash from a dead zone; or from presliding: their predictions"
    assert page.text.count(said) == 2


@pytest.mark.usefixtures("unpainted")
def test_a_law_is_the_last_step_of_the_falling_error(found: Diagnosis) -> None:
    law: Any = SimpleNamespace(held_out_after_deg=0.05, floor_deg=0.03)
    for added_to, name in (((), "linear model + law"), (found.effects, "+ law")):
        law.added_to = added_to
        story: Any = SimpleNamespace(result=replace(found, law=law), floor_deg=0.03)
        shown = ladder.section(story)
        assert shown is not None
        names = [step.name for step, _ in shown.values["steps"]]
        assert names == ["linear model", "+ backlash", name]
        last, floors = shown.values["steps"][-1]
        assert (last.held_out_deg, last.validation_deg, last.explained) == (0.05, None, False)
        assert floors == pytest.approx(0.05 / 0.03)


@pytest.mark.usefixtures("unpainted")
def test_findings_are_told_as_they_are(
    tmp_path: Path,
    found: Diagnosis,
    compared: Comparison,
    recording: Recording,
    told: tuple[str, Page],
) -> None:
    """The page, the JSON and the sentences hold the same findings."""
    assert found.findings
    short = written(tmp_path / "report.html", compared, [recording])
    for result, (_, page) in ((found, told), (compared, short)):
        for one, entry in zip(result.findings, result.to_dict()["findings"], strict=True):
            assert " ".join(one.sentence.split()) in page.text
            assert set(entry) == {"test", "sentence", "size_deg", "share", "p"}
    assert compared.to_dict()["sentences"][1:] == [one.sentence for one in compared.findings]


def test_the_proposed_experiment_is_drawn(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    made = design("triangle", CommandLimits(15.0, None, 8.0))
    limits = CommandLimits(15.0, None, 8.0)
    pair = Separation(between=("backlash", "dead_zone"), log_likelihood=4.0, difference_deg=0.012)
    other = Separation(
        between=("backlash", "coulomb_friction"), log_likelihood=40.0, difference_deg=0.1
    )
    proposal = Proposal.of(made, limits, (pair, other), 0.02, 0.01)
    _, page = written(tmp_path / "report.html", replace(found, proposal=proposal), [recording])
    assert "experiment" in page.ids
    assert made.words in page.text
    assert "backlash or dead zone" in page.text
    assert "No command within these limits distinguishes all models" in page.text


@pytest.mark.usefixtures("unpainted")
def test_no_experiment_is_drawn_that_decides_nothing(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    limits = CommandLimits(15.0, None, 8.0)
    pair = Separation(between=("backlash", "dead_zone"), log_likelihood=4.0, difference_deg=0.012)
    undecided = Proposal.of(design("triangle", limits), limits, (pair,), 0.02, 0.01)
    for without in (None, undecided):
        _, page = written(tmp_path / "without.html", replace(found, proposal=without), [recording])
        assert "experiment" not in page.ids


def test_groups_that_cannot_be_told_apart_are_named_once() -> None:
    rivals = {"a": ("b",), "b": ("a",), "c": ()}
    candidates: Any = [SimpleNamespace(effect=k, confounded_with=v) for k, v in rivals.items()]
    assert groups(candidates) == [("a", "b")]


@pytest.mark.usefixtures("unpainted")
def test_what_lies_beyond_the_fitted_data_and_what_could_not_have_shown(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    beyond = Regime(
        quantity="speed",
        unit="deg/s",
        fitted_low=0.0,
        fitted_high=50.0,
        beyond="above",
        limit=55.0,
        reached=218.0,
        share_samples=0.62,
        share_error=0.94,
        rmse_deg=1.08,
        recording="fast",
        use="test",
        leading=True,
        sentence="94 % of the squared error on fast lies at a speed above 55.0 deg/s",
        remedy="",
    )
    sizes = {one.effect: one for one in found.detectable}
    unseen = [replace(sizes["cogging"], value=None), sizes["dead_zone"]]
    shown = replace(found, regimes=Table([beyond]), detectable=Table(unseen))
    _, page = written(tmp_path / "beyond.html", shown, [recording])
    assert "regimes" in page.ids
    assert "Beyond the fitted data" in page.text
    assert "speed 50.0 deg/s 218 deg/s 62 % 94 % 1.08 deg" in page.text
    assert f"{beyond.sentence}." in page.text
    assert "could not have shown, whatever the size: cogging" in page.text
    assert "a dead zone would have shown from" in page.text
