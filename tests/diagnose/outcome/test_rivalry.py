"""Candidates by evidence and the models that predict the same, from invented scores."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.outcome import _rivalry
from servosight.diagnose.residuals import TEST, Judged
from servosight.diagnose.selection import AcceptanceCriterion, PriorKnowledge, Score
from servosight.models.core import Recording

COUNT = 1000
TIME_S = np.arange(COUNT) / 100.0
CRITERION = AcceptanceCriterion(0.1, 0.0)
LEVELS = SimpleNamespace(noise_deg=0.1, tolerance_deg=0.0)
DATA: Any = SimpleNamespace(levels=LEVELS)


def trial(effects: str, error_deg: float) -> Any:
    score = Score(
        effects=tuple(effects),
        parameters=3 + len(effects),
        samples=COUNT,
        mean_square_deg2=error_deg**2,
        train_rmse_deg=error_deg,
        validation_rmse_deg=error_deg,
        validation_samples=300,
        gain_fitted=True,
    )
    return SimpleNamespace(
        effects=tuple(effects),
        score=score,
        key=(tuple(effects), ()),
        validation_rmse_deg=error_deg,
    )


LINEAR = trial("", 1.0)


def outcome(
    last: Any, singles: tuple[Any, ...] = (), auto: bool = True, linear: Any = LINEAR, **known: Any
) -> Any:
    def tested(one: Any) -> tuple[Judged, ...]:
        angle = np.full(COUNT, 2.0 * one.score.validation_rmse_deg)
        recording = Recording("run", TIME_S, np.zeros(COUNT), TIME_S, angle)
        return (Judged(recording, np.zeros(COUNT), np.full(COUNT, TEST, np.int8)),)

    models = SimpleNamespace(
        whole=None,
        tested=tested,
        known=PriorKnowledge(**known),
        alike=lambda chosen: [LINEAR, trial("x", 0.2), trial("y", 0.2)],
        candidates=lambda base: [one.effects[-1] for one in singles] + ["d"] * bool(singles),
        sketched=lambda base, name: SimpleNamespace(fit=trial(name, 0.8)),
        judge=lambda fit: fit,
    )
    selected = SimpleNamespace(singles=singles)
    return SimpleNamespace(
        models=models, selected=selected, linear=linear, last=last, auto=auto, criterion=CRITERION
    )


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Who is confounded and who predicts the same as the chosen one; what was asked."""
    told: dict[str, Any] = {"same": [], "tried": [], "proposed": []}

    def confounded(trials: Any, base: Any, resolution: Any, whole: Any) -> dict[str, Any]:
        return {one.effects[-1]: (f"like {one.effects[-1]}",) for one in trials}

    def alternatives(chosen: Any, tried: Any, resolution: Any, whole: Any) -> list[Any]:
        told["tried"] = [one.effects for one in tried]
        return list(told["same"])

    def propose(rivals: Any, models: Any, *levels: Any) -> str:
        told["proposed"].append((len(rivals), levels))
        return "a command"

    monkeypatch.setattr(_rivalry, "confounded", confounded)
    monkeypatch.setattr(_rivalry, "alternatives", alternatives)
    monkeypatch.setattr(_rivalry, "propose", propose)
    return told


def test_candidates_come_by_their_evidence(seen: dict[str, Any]) -> None:
    singles = trial("b", 0.5), trial("a", 0.3), trial("c", 0.9)
    found = _rivalry.rivalry(outcome(LINEAR, singles), DATA, None).candidates
    assert [one.effect for one in found] == ["a", "b", "d", "c"]  # d was not tried in the search
    first = found[0]
    assert first.evidence == pytest.approx(COUNT * np.log(1.0 / 0.3) - 0.5 * np.log(COUNT))
    assert first.validation_rmse_deg == 0.3
    assert first.held_out_rmse_deg == pytest.approx(0.6)
    assert first.confounded_with == ("like a",)


def test_the_chosen_model_has_rivals_and_a_command_tells_them_apart(seen: dict[str, Any]) -> None:
    chosen, other = trial("a", 0.1), trial("x", 0.1)
    alone = _rivalry.rivalry(outcome(chosen), DATA, None)
    assert (alone.rivals, alone.proposal) == ((chosen,), None)
    assert seen["proposed"] == []
    seen["same"] = [other]
    both = _rivalry.rivalry(outcome(chosen, without_effects=("y",)), DATA, None)
    assert both.rivals == (chosen, other)
    assert both.proposal == "a command"
    assert seen["proposed"] == [(2, (0.1, 0.0, None))]
    assert seen["tried"] == [(), ("x",)]


@pytest.mark.parametrize("error_deg", [1.0, 0.995])
def test_what_gains_too_little_has_no_rivals(seen: dict[str, Any], error_deg: float) -> None:
    """Less than ten in log-likelihood, of which the further parameter costs 3.5."""
    assert _rivalry.rivalry(outcome(trial("a", error_deg)), DATA, None).rivals == ()


def test_a_model_that_did_not_grow_has_no_rivals(seen: dict[str, Any]) -> None:
    assert _rivalry.rivalry(outcome(trial("", 0.1)), DATA, None).rivals == ()


def test_without_steps_the_best_candidate_stands_for_what_would_be_next(
    seen: dict[str, Any],
) -> None:
    singles = trial("b", 0.3), trial("a", 0.5)
    ranked = _rivalry.rivalry(outcome(LINEAR, singles, auto=False), DATA, None)
    assert ranked.rivals == (singles[0],)
    assert _rivalry.rivalry(outcome(LINEAR, singles), DATA, None).rivals == ()
    assert _rivalry.rivalry(outcome(LINEAR, auto=False), DATA, None).rivals == ()
    low = trial("", 0.1)
    at_floor = outcome(low, (trial("b", 0.05),), auto=False, linear=low)
    assert _rivalry.rivalry(at_floor, DATA, None).rivals == ()


def test_the_best_single_candidate_is_accepted_where_it_earns_its_place() -> None:
    singles = trial("a", 0.1), trial("b", 0.5)
    assert _rivalry.accepted(outcome(LINEAR, singles)) == "a"
    assert _rivalry.accepted(outcome(LINEAR, (trial("a", 0.99),))) is None
    assert _rivalry.accepted(outcome(LINEAR)) is None
    known = trial("k", 1.0)
    assert _rivalry.accepted(outcome(known, (trial("ka", 0.1),), linear=known)) == "a"
