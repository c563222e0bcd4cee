"""What is fitted before the model of fewest assumptions is chosen, on tables of invented models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from support.invented_models import InventedModels, InventedTrial

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SearchEffort,
    SelectionPolicy,
    Step,
)
from servosight.diagnose.selection.search import (
    Visited,
    fewest_assumptions,
    simplified,
    with_own_gain,
)
from servosight.models.effects import Usual

POLICY = SelectionPolicy(ordinary=("a", "b", "c", "d", "f", "g", "w"))
CRITERION = AcceptanceCriterion(0.1, 0.0, POLICY)
HELD = ("k",)
EFFORT = SearchEffort()


def visited(models: InventedModels, criterion: AcceptanceCriterion = CRITERION) -> Visited:
    return Visited(models, criterion)  # type: ignore[arg-type]


def steps_of(*trials: InventedTrial) -> list[Any]:
    return [Step(trial) for trial in trials]  # type: ignore[arg-type]


# k fitted in the place of an effect


def own_gain(
    free: Mapping[str, float], last: str, held: Sequence[str] = HELD, **changes: Any
) -> tuple[str, InventedModels]:
    """The effects at the end, where ``last`` explains the data and ``free`` have k fitted."""
    models = InventedModels({"": 1.0, last: 0.1, **free}, **changes)
    first = models.first()
    between = models.fitted(tuple(last[:1]), "step", HELD)
    steps = steps_of(first, between, models.fitted(tuple(last), "step", tuple(held)))
    models.done.clear()
    found = with_own_gain(steps, visited(models))
    return "".join(found[-1].trial.effects), models


def test_a_k_takes_the_place_of_the_effect_that_stood_for_it() -> None:
    found, models = own_gain({"a": 0.1, "b": 0.5}, "ab")
    assert found == "a"
    assert sorted(one for one in models.done if one.startswith("free")) == ["free a", "free b"]


def test_a_k_takes_no_place_where_the_rest_does_not_explain() -> None:
    assert own_gain({"a": 0.115, "b": 0.5}, "ab")[0] == "ab"


def test_of_what_explains_with_a_k_the_cheapest_is_taken() -> None:
    """``r`` is no ordinary effect; ``b`` beside it is cheaper, and does not explain."""
    assert own_gain({"a": 0.1, "r": 0.1}, "ar")[0] == "a"
    assert own_gain({"b": 0.115, "r": 0.1}, "br")[0] == "r"


def test_an_effect_that_was_known_before_is_not_replaced_by_a_k() -> None:
    known = PriorKnowledge(with_effects=("a",))
    found, models = own_gain({"a": 0.1, "b": 0.1}, "ab", known=known)
    assert found == "a"
    assert "free b" not in models.done


def test_nothing_is_fitted_where_k_is_fitted_already_or_nothing_is_explained() -> None:
    assert own_gain({"a": 0.1}, "ab", held=())[1].done == []
    models = InventedModels({"": 1.0, "ab": 0.5})
    steps = steps_of(models.first(), models.fitted(tuple("ab"), "step", HELD))
    models.done.clear()
    assert with_own_gain(steps, visited(models)) == steps
    assert models.done == []


# What is fitted before the choice


def chosen(models: InventedModels, *begun: str, effort: SearchEffort = EFFORT) -> InventedTrial:
    """The last model once the steps to the last of ``begun`` are simplified."""
    trials = [models.first(), *(models.fitted(tuple(one), "step") for one in begun)]
    models.done.clear()
    found = simplified(steps_of(*trials), visited(models), effort)
    return found[-1].trial  # type: ignore[return-value]


SERVO = {"": 1.0, "a": 0.9, "b": 0.8, "ab": 0.4}
USUAL = {"w": Usual.WEIGHT, "f": Usual.FRICTION, "g": Usual.FRICTION}


def servo(**changes: Any) -> InventedModels:
    """A weight ``w`` and the frictions ``f`` and ``g`` beside what takes effect."""
    errors = {**SERVO, **dict.fromkeys("fgw", 1.0)}
    return InventedModels(errors, **{"usual": USUAL, "k_may_be_held": True, **changes})


def test_the_usual_is_fitted_with_k_held_beside_the_last_and_alone() -> None:
    """Then the models with k fitted, at most as large as the last with its k, cheapest first."""
    models = servo()
    chosen(models, "a", "b", "ab")
    together = [one for one in models.done if one.startswith("together")]
    assert together == ["together abw", "together fw", "together gw"]
    assert {one.held for one in models.trials.values() if "w" in one.effects} == {HELD}
    assert [one for one in models.done if one.startswith("hold")] == ["hold ab", "hold b", "hold a"]


def test_so_many_of_the_cheapest_are_fitted_with_k_held() -> None:
    """Larger ones than the last with its k are left out, and those with k held already."""
    models = InventedModels({**SERVO, "abcd": 0.3, "c": 0.7, "ac": 0.5}, k_may_be_held=True)
    for effects in ("abcd", "c", "ac"):
        models.fitted(tuple(effects), "before")
    models.fitted(("b",), "before", HELD)
    chosen(models, "a", "ab")
    assert [one for one in models.done if one.startswith("hold")] == [
        "hold ab",
        "hold ac",
        "hold c",
    ]
    models = InventedModels({"": 1.0, "a": 0.5, "ab": 0.3}, k_may_be_held=True)
    models.fitted(tuple("ab"), "before")
    chosen(models, "a")
    assert [one for one in models.done if one.startswith("hold")] == ["hold ab", "hold a"]


@pytest.mark.parametrize(
    ("changes", "together"),
    [
        ({"at_one_gain": False}, []),
        ({"k_may_be_held": False}, []),
        ({"usual": {}}, []),
        ({"known": PriorKnowledge(without_effects=("w",))}, []),
        ({"known": PriorKnowledge(without_effects=("f",))}, ["together abw", "together gw"]),
        ({"usual": {"w": Usual.WEIGHT}}, ["together abw"]),
    ],
    ids=[
        "several gains",
        "k not held",
        "none is usual",
        "no weight",
        "no friction f",
        "one weight",
    ],
)
def test_the_usual_is_fitted_only_where_it_may_be(
    changes: dict[str, Any], together: list[str]
) -> None:
    models = servo(**changes)
    chosen(models, "a", "ab")
    assert [one for one in models.done if one.startswith("together")] == together


def test_what_is_known_before_is_in_all_of_it() -> None:
    models = servo(known=PriorKnowledge(with_effects=("a",)))
    chosen(models, "ab")
    together = [one for one in models.done if one.startswith("together")]
    assert together == ["together abw", "together afw", "together agw"]


def test_the_usual_is_fitted_once_and_also_where_it_is_all_there_is() -> None:
    models = InventedModels({"": 1.0, "f": 0.5, "w": 0.9}, usual=USUAL, k_may_be_held=True)
    chosen(models, "f")
    assert models.done.count("together fw") == 1
    models = InventedModels({"": 1.0, "f": 0.5, "w": 0.9}, usual=USUAL, k_may_be_held=True)
    models.fitted(tuple("fw"), "before", HELD)
    chosen(models, "f")
    assert "together fw" not in models.done


@pytest.mark.parametrize(("spent", "fitted"), [(4.0, False), (4.5, True), (2.0, False)])
def test_nothing_is_fitted_once_the_whole_cost_is_spent(spent: float, fitted: bool) -> None:
    """Four simulations have been made: the linear one, that with k held, and two steps."""
    models = servo()
    models.unloaded()
    chosen(models, "a", "ab", effort=SearchEffort(cost=spent))
    assert bool([one for one in models.done if one.startswith("hold")]) is fitted


@pytest.mark.parametrize("reason", ["no effects", "own recordings", "explained", "on all data"])
def test_the_last_model_stays_and_nothing_is_fitted(reason: str) -> None:
    """``c`` has an assumption less and errs as much."""
    models = servo(
        held_deg={"c": 0.4},
        explained_with_validation=("ab",) if reason == "on all data" else (),
        split=SimpleNamespace(carried=(None,) if reason == "own recordings" else ()),
        validation_deg={"ab": 0.1} if reason == "explained" else {},
    )
    models.fitted(("c",), "before", HELD)
    last = chosen(models, *(() if reason == "no effects" else ("a", "ab")))
    assert "".join(last.effects) == ("" if reason == "no effects" else "ab")
    assert last.held == ()
    assert models.done == []


def test_the_last_model_with_k_held_where_that_errs_as_much() -> None:
    models = servo()
    last = chosen(models, "a", "ab")
    assert (last.effects, last.held) == (("a", "b"), HELD)


def test_the_model_is_that_which_the_last_fit_of_it_came_to() -> None:
    models = servo(finished_deg={"ab": 0.39})
    last = chosen(models, "a", "ab")
    assert last is models.trials[("a", "b"), HELD]
    assert last.fit.cost == 0.39


def test_a_last_model_that_was_fitted_again_since_stays_itself() -> None:
    models = InventedModels(SERVO)
    steps = steps_of(models.first(), models.fitted(tuple("ab"), "step"))
    models.fitted(tuple("ab"), "again")
    assert simplified(steps, visited(models), SearchEffort())[-1].trial is steps[-1].trial


# The choice


def told(
    last: InventedTrial,
    *tried: InventedTrial,
    criterion: AcceptanceCriterion = CRITERION,
    refused: Sequence[InventedTrial] = (),
) -> Any:
    """The model that is preferred; all are accepted that are not ``refused``."""

    def is_accepted(trial: Any) -> bool:
        return all(trial is not one for one in refused)

    return fewest_assumptions(tried, last, criterion, is_accepted)  # type: ignore[arg-type]


def trial(effects: str, error_deg: float, held: tuple[str, ...] = HELD, **score: Any) -> Any:
    found = InventedModels({"": 1.0})._trial(tuple(effects), error_deg, held)
    return replace(found, score=replace(found.score, **score))


def test_the_linear_model_is_never_preferred() -> None:
    last = trial("a", 0.95)
    for held in (HELD, ()):
        assert told(last, trial("", 0.96, held), last) is last


def test_a_model_with_more_assumptions_is_not_preferred() -> None:
    last = trial("ab", 0.4)
    assert told(last, last, trial("abc", 0.3), trial("ac", 0.38, ())) is last


def test_an_effect_less_is_preferred_within_an_effects_price() -> None:
    """Of the least price, which is not the last one's."""
    last, least = trial("ab", 0.40), trial("ac", 0.38)
    price = CRITERION.overall_price(least.score) + POLICY.effect_price
    assert CRITERION.overall_price(trial("d", 0.4618).score) < price
    assert CRITERION.overall_price(trial("d", 0.475).score) > price
    for error_deg, preferred in ((0.4618, "d"), (0.475, "ac")):
        found = told(last, last, least, trial("d", error_deg))
        assert "".join(found.effects) == preferred


def test_the_least_price_is_that_of_a_model_that_is_accepted() -> None:
    last, refused = trial("ab", 0.40), trial("ac", 0.30)
    one = trial("d", 0.48)
    assert told(last, last, refused, one, refused=[refused]) is one
    assert told(last, last, refused, one) is refused


def test_a_dearer_model_does_not_raise_the_least_price() -> None:
    """Where the last one is not among those that were tried."""
    last, dearer, fewer = trial("ab", 0.40), trial("ac", 0.42), trial("d", 0.50)
    least = CRITERION.overall_price(last.score)
    assert least < CRITERION.overall_price(dearer.score) < least + POLICY.effect_price
    assert CRITERION.overall_price(fewer.score) > least + POLICY.effect_price
    assert told(last, dearer, fewer) is dearer


def test_a_model_at_the_least_price_is_near_it() -> None:
    free = AcceptanceCriterion(0.1, 0.0, replace(POLICY, effect_price=0.0))
    last, least = trial("ab", 0.40), trial("ac", 0.35)
    assert told(last, last, least, criterion=free) is least


def test_of_as_many_assumptions_k_at_one_comes_first_and_then_the_cheapest() -> None:
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
