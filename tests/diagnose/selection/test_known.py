"""What the user knows before: models to start from, effects settled, parameters held."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import servosight as ss
from servosight.app.main import main
from servosight.diagnose import Diagnosis, PriorKnowledge, diagnose
from servosight.diagnose.selection import ModelSelection, Split
from servosight.identify.fit import fit_effects
from servosight.identify.problem import Problem
from servosight.models.core import Actuator, Estimate, InputError
from servosight.models.effects import catalogue

NOISE_DEG = 0.03
CARD = Actuator(
    {
        "k": Estimate(1.0, 0.01, "-"),
        "T": Estimate(0.02, None, "s"),
        "xi": Estimate(0.6, None, "-"),
        "bias": Estimate(0.0, None, "deg"),
        "coulomb_friction.level": Estimate(0.1, None, "deg"),
    },
    ("coulomb_friction",),
)


def selection(twin: Any, **known: Any) -> ModelSelection:
    split = Split.of([twin("backlash")[0]], (), ())
    return ModelSelection(split, catalogue(), PriorKnowledge.of(catalogue(), **known))


def test_without_knowledge_the_linear_model_is_first(twin: Any) -> None:
    models = selection(twin)
    assert models.first() is models.linear()
    assert set(models.candidates(models.first())) == set(catalogue())


def test_the_first_model_has_what_is_known(twin: Any) -> None:
    models = selection(twin, start=CARD, with_effects=["backlash"], fix={"k": 1.0})
    first = models.first()
    assert first is models.first()
    assert set(first.effects) == {"coulomb_friction", "backlash"}
    truth = twin("backlash")[1]["backlash.gap"]
    found = first.fit.problem.values(first.fit.outcome.point)
    assert found["k"] == 1.0
    assert found["backlash.gap"] == pytest.approx(truth, rel=0.02)
    assert first.score.parameters == len(found) - 1  # k does not count


def test_several_known_effects_are_fitted_out_of_the_minimum_in_which_one_search_ends() -> None:
    """Truth: 2 deg of play and Stribeck friction. One effect after the other ends at a play of 1.4
    deg, at four times the noise. Sigma of the play is 0.004 deg; 0.02 allows for the twin's stops.
    """
    pair = ["backlash", "stribeck_friction"]
    recording = ss.simulate(effect=pair, seed=5)
    models = ModelSelection(
        Split.of([recording], (), ()),
        catalogue(),
        PriorKnowledge.of(catalogue(), with_effects=pair),
    )
    first = models.first()
    lower = models.lowered(first, NOISE_DEG)
    assert first.fit.rmse_deg > 3.0 * NOISE_DEG
    assert lower.fit.rmse_deg < 1.1 * NOISE_DEG
    assert models.first() is lower
    found = lower.fit.problem.values(lower.fit.outcome.point)
    assert found["backlash.gap"] == pytest.approx(
        recording.truth["parameters"]["backlash.gap"], abs=0.02
    )


def test_a_user_who_holds_k_is_asked_for_no_other(twin: Any) -> None:
    assert selection(twin, fix={"k": 0.9}).unloaded() is None
    models = selection(twin)
    unloaded = models.unloaded()
    assert unloaded is not None
    assert unloaded.fit.problem.held == {"k": 1.0}
    assert unloaded is models.unloaded()
    assert unloaded is not models.linear()  # the same effects, less one parameter
    (one,) = models.recordings
    both = Split.of([one, replace(one, relative_gain=2.0)], (), ())
    assert models.at_one_gain
    assert not models.with_split(both).at_one_gain  # two gains tell k from load and friction
    assert models.refitted(unloaded).score.parameters == unloaded.score.parameters + 1


def test_what_is_ruled_out_is_no_candidate(twin: Any) -> None:
    models = selection(twin, without_effects=["backlash"], with_effects=["coulomb_friction"])
    found = models.candidates(models.linear())
    assert "backlash" not in found
    # They contain coulomb_friction, and would take its place.
    assert not {"presliding", "stribeck_friction"} & set(found)


def test_what_a_model_may_lack() -> None:
    known = PriorKnowledge.of(
        catalogue(), start=CARD, with_effects=["backlash"], without_effects=["cogging"]
    )
    assert known.first == ("coulomb_friction", "backlash")
    assert known.removable(known.first) == ("coulomb_friction",)
    assert known.allows(["backlash", "dead_zone"])
    assert known.allows(["backlash"])
    assert not known.allows(["dead_zone"])
    assert not known.allows(["backlash", "cogging"])


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({"with_effects": ["cogging"], "without_effects": ["cogging"]}, "both required and ruled"),
        ({"start": CARD, "without_effects": ["coulomb_friction"]}, "the model to start from has"),
        ({"start": CARD, "with_effects": ["presliding"]}, "contains coulomb_friction"),
        ({"with_effects": ["slack"]}, "unknown effect 'slack'"),
        ({"fix": {"backlash.gap": 1.0}}, "the model has no effect backlash"),
        ({"with_effects": ["backlash"], "fix": {"backlash.gap": -1.0}}, "the value is -1"),
    ],
)
def test_contradictions_are_refused(known: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        PriorKnowledge.of(catalogue(), **known)


@pytest.fixture(scope="module")
def found(twin: Any) -> Diagnosis:
    """Known: k, a friction that this servo does not have, and that no time passes."""
    known = PriorKnowledge.of(
        catalogue(),
        with_effects=["quadratic_drag"],
        without_effects=["dead_time"],
        fix={"k": twin("backlash")[1]["k"]},
    )
    return diagnose([twin("backlash")[0]], auto=True, prior=known)


def test_a_diagnosis_keeps_to_what_is_known(found: Diagnosis, twin: Any) -> None:
    assert found.verdict == "explained"
    assert found.effects == ("quadratic_drag", "backlash")
    assert [step.added for step in found.ladder] == [None, "backlash"]
    assert found.ladder[0].effects == ("quadratic_drag",)
    assert "dead_time" not in {one.effect for one in found.candidates}
    k = found.ladder[-1].parameters["k"]
    assert isinstance(k, Estimate)
    assert (k.value, k.sigma) == (twin("backlash")[1]["k"], 0.0)
    gap = found.ladder[-1].parameters["backlash.gap"]
    assert isinstance(gap, Estimate)
    assert gap.value == pytest.approx(twin("backlash")[1]["backlash.gap"], rel=0.02)
    assert found.headline == "What was missing: backlash"
    assert found.summary.startswith("The model with quadratic drag of this servo lacks backlash.")


def test_what_was_known_is_saved(found: Diagnosis, tmp_path: Any) -> None:
    found.save(tmp_path / "diagnosis.json")
    assert Diagnosis.load(tmp_path / "diagnosis.json").known == found.known
    assert found.to_dict()["known"]["without_effects"] == ["dead_time"]


def test_a_model_that_is_right_stays(twin: Any) -> None:
    """Without --auto: the first step has the model's effects, from its values."""
    recording, truth = twin("backlash")
    values = {name: Estimate(value, None, "") for name, value in truth.items()}
    others = [name for name in catalogue() if name not in ("backlash", "coulomb_friction")]
    right = Actuator(values, ("backlash",))
    known = PriorKnowledge.of(catalogue(), start=right, without_effects=others)
    result = diagnose([recording], prior=known)
    assert (result.verdict, result.effects) == ("explained", ("backlash",))
    assert result.headline == "No further effect is missing"
    assert len(result.ladder) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--with", "cogging", "--without", "cogging"], "both required and ruled out"),
        (["--with", "backlash,cogging", "--without", "cogging"], "both required and ruled out"),
        (["--from", "card.toml", "--without", "coulomb_friction"], "the model to start from"),
        (["--fix", "backlash.gap=1"], "the model has no effect backlash"),
        (["--fix", "k"], "expected NAME=VALUE"),
    ],
)
def test_the_command_line_refuses_contradictions(
    words: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    CARD.save("card.toml")
    assert main(["diagnose", "rec", *words]) == 2
    assert said in capsys.readouterr().err


def test_an_effect_that_is_not_needed_is_left_out(twin: Any) -> None:
    """Of a servo without any: the model to start from has one, and no other may be tried."""
    others = [name for name in catalogue() if name != "coulomb_friction"]
    known = PriorKnowledge.of(catalogue(), start=CARD, without_effects=others)
    result = diagnose([twin()[0]], auto=True, prior=known)
    assert (result.verdict, result.effects) == ("no_effect_missing", ())
    assert [step.removed for step in result.ladder] == [None, "coulomb_friction"]
    assert result.headline == "Not needed: Coulomb friction"
    assert not result.candidates


def test_a_held_effect_does_not_contain_the_linear_model(twin: Any) -> None:
    """Its fit may well be worse, and nothing is done again then."""
    recording = twin("backlash")[0]
    problem = Problem.of([recording], catalogue(), ["dead_zone"], held={"dead_zone.half_width": 9})
    held, linear = fit_effects(problem), fit_effects(problem.linear)
    assert held.outcome.cost > linear.outcome.cost
    assert not held.notes
