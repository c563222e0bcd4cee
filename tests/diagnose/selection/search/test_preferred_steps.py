"""Which model is the one of fewest assumptions, on tables of invented models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from support.invented_models import CRITERION, HELD, POLICY, InventedModels, InventedTrial

from servosight.diagnose.selection import AcceptanceCriterion
from servosight.diagnose.selection.search import fewest_assumptions


def told(
    last: InventedTrial,
    *tried: InventedTrial,
    criterion: AcceptanceCriterion = CRITERION,
    refused: Sequence[InventedTrial] = (),
) -> Any:
    """The model that is preferred; all are accepted that are not ``refused``."""

    def is_accepted(trial: Any) -> bool:
        return all(trial is not one for one in refused)

    def as_tried(trial: Any) -> Any:
        return trial.score

    return fewest_assumptions(tried, last, criterion, is_accepted, as_tried)  # type: ignore[arg-type]


def trial(effects: str, error_deg: float, held: tuple[str, ...] = HELD, **score: Any) -> Any:
    found = InventedModels({"": 1.0})._trial(tuple(effects), error_deg, held)
    return replace(found, score=replace(found.score, **score))


def test_the_linear_model_is_never_preferred() -> None:
    last = trial("a", 0.95)
    for held in (HELD, ()):
        assert told(last, trial("", 0.96, held), last) is last


def test_more_assumptions_are_preferred_at_a_penalised_error_lower_by_that_of_an_effect() -> None:
    last = trial("ab", 0.4)
    assert told(last, last, trial("abc", 0.34), trial("ac", 0.38, ())) is last
    larger = trial("abc", 0.32)
    assert told(last, last, larger) is larger


def test_an_effect_less_is_preferred_within_an_effects_penalty() -> None:
    """Of the least penalised error, which is not the last one's."""
    last, least = trial("ab", 0.40), trial("ac", 0.38)
    most = CRITERION.overall_penalised_error(least.score) + POLICY.effect_penalty
    assert CRITERION.overall_penalised_error(trial("d", 0.4618).score) < most
    assert CRITERION.overall_penalised_error(trial("d", 0.475).score) > most
    for error_deg, preferred in ((0.4618, "d"), (0.475, "ac")):
        found = told(last, last, least, trial("d", error_deg))
        assert "".join(found.effects) == preferred


def test_the_least_penalised_error_is_that_of_a_model_that_is_accepted() -> None:
    last, refused = trial("ab", 0.40), trial("ac", 0.30)
    one = trial("d", 0.48)
    assert told(last, last, refused, one, refused=[refused]) is one
    assert told(last, last, refused, one) is refused


def test_a_higher_model_does_not_raise_the_least_penalised_error() -> None:
    last, higher, fewer = trial("ab", 0.40), trial("ac", 0.42), trial("d", 0.50)
    least = CRITERION.overall_penalised_error(last.score)
    assert least < CRITERION.overall_penalised_error(higher.score) < least + POLICY.effect_penalty
    assert CRITERION.overall_penalised_error(fewer.score) > least + POLICY.effect_penalty
    for tried in ([last, higher, fewer], [fewer, higher, last]):
        assert told(last, *tried) is last


def test_a_model_at_the_least_penalised_error_is_near_it() -> None:
    free = AcceptanceCriterion(0.1, 0.0, replace(POLICY, effect_penalty=0.0))
    last, least = trial("ab", 0.40), trial("ac", 0.35)
    assert told(last, last, least, criterion=free) is least


def test_of_as_many_assumptions_k_at_one_comes_first_and_then_the_best_ranked() -> None:
    last = trial("a", 0.40, ())
    assert told(last, last, trial("bc", 0.41)).held == HELD
    found = told(last, last, trial("bc", 0.42), trial("ac", 0.41), trial("bd", 0.415))
    assert "".join(found.effects) == "ac"


ACCEPTED = {"validation_rmse_deg": 0.2}
"""An error by which one effect more is accepted."""


@pytest.mark.parametrize(
    ("other", "held", "superseded"),
    [("ab", HELD, True), ("bc", HELD, False), ("ab", (), False), ("abc", HELD, False)],
    ids=["one more", "others", "with k fitted", "two more"],
)
def test_a_model_is_superseded_by_itself_with_one_effect_more(
    other: str, held: tuple[str, ...], superseded: bool
) -> None:
    simple, larger = trial("a", 0.41), trial(other, 0.40, held, **ACCEPTED)
    last = trial("bcd", 0.40)
    assert (told(last, last, simple, larger) is not simple) is superseded


@pytest.mark.parametrize(("evidence", "superseded"), [(9.9, False), (10.1, True)])
def test_one_of_one_supersedes(evidence: float, superseded: bool) -> None:
    """Nothing is added to the evidence that is needed, as none was chosen among others."""
    larger = trial("ab", 0.40, **ACCEPTED)
    simple, last = trial("a", 0.41), trial("bcd", 0.40)
    nothing = CRITERION.evidence(larger.score, replace(simple.score, mean_square_deg2=0.16))
    square = 0.16 * float(2.718281828459045 ** ((evidence - nothing) / 500.0))
    simple = replace(simple, score=replace(simple.score, mean_square_deg2=square))
    assert CRITERION.evidence(larger.score, simple.score) == pytest.approx(evidence)
    assert (told(last, last, simple, larger) is not simple) is superseded
