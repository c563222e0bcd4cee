"""What is fitted before the model of fewest assumptions is chosen, on tables of invented models."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from support.invented_models import HELD, InventedModels, InventedTrial, steps_of, visited

from servosight.diagnose.selection import PriorKnowledge, SearchEffort
from servosight.diagnose.selection.search import simplified
from servosight.models.effects import Usual

EFFORT = SearchEffort()


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
    """Then the models with k fitted, at most as large as the last with its k, best-ranked first."""
    models = servo()
    chosen(models, "a", "b", "ab")
    together = [one for one in models.done if one.startswith("together")]
    assert together == ["together abw", "together fw", "together gw"]
    assert {one.held for one in models.trials.values() if "w" in one.effects} == {HELD}
    assert [one for one in models.done if one.startswith("hold")] == ["hold ab", "hold b", "hold a"]


def test_so_many_of_the_best_ranked_are_fitted_with_k_held() -> None:
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
