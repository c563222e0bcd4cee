"""What the wider search fits and where it ends, on tables of invented models."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SearchEffort,
    SelectionPolicy,
    Step,
)
from servosight.diagnose.selection.search import BackwardSearch, BeamSearch, Visited, fitted_jointly
from servosight.diagnose.selection.search._wide import _simplest
from servosight.models.core import silent
from servosight.models.effects import Place

CRITERION = AcceptanceCriterion(0.1, 0.0, SelectionPolicy(ordinary=("a", "b", "c", "d")))
EFFORT = SearchEffort(beam=1)


def reduced(errors: dict[str, float], rich: str, effort: SearchEffort = EFFORT) -> list[str]:
    """The models that are fitted on the way down from a rich one."""
    models = InventedModels(errors)
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    trial = models.fitted(tuple(rich), "rich")
    BackwardSearch(models, visited, effort, silent).reduce(trial)  # type: ignore[arg-type]
    return models.done[1:]


def test_effects_are_left_out_down_to_the_last() -> None:
    assert reduced({"": 0.2, "a": 0.1, "ab": 0.1}, "ab") == ["reduce b", "reduce a"]
    down = ["reduce bc", "reduce ac", "reduce ab", "reduce b", "reduce a"]
    assert reduced({"": 0.2, "ab": 0.12, "abc": 0.1}, "abc") == down


def test_the_way_down_ends_at_two_effects_penalties_above_its_best_ranked() -> None:
    assert reduced({"": 0.3, "ab": 0.15, "abc": 0.1}, "abc") == [
        "reduce bc",
        "reduce ac",
        "reduce ab",
    ]


def test_effects_at_a_bound_go_first() -> None:
    """``a`` is missed most, and nothing is accepted with it."""
    models = InventedModels({"": 0.3, "a": 0.2, "bc": 0.11, "abc": 0.1}, at_bounds="a")
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    rich = models.fitted(tuple("abc"), "rich")
    BackwardSearch(models, visited, EFFORT, silent).reduce(rich)  # type: ignore[arg-type]
    assert models.done[1:] == ["reduce bc", "reduce c", "reduce b"]


def test_models_with_an_effect_at_a_bound_rank_last_and_are_not_accepted() -> None:
    """``a`` lowers the error most, at a bound; nothing that extends it is worth a fit."""
    models = InventedModels({"": 1.0, "a": 0.1, "b": 0.3}, at_bounds="a")
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    for effects in ("", "a", "b"):
        models.fitted(tuple(effects), "first")
    assert ["".join(one.effects) for one in visited.ranked()] == ["b", "", "a"]
    assert not visited.is_accepted(models.trials[("a",), ()])  # type: ignore[arg-type]
    assert visited.best().effects == ("b",)


def test_an_effect_at_a_bound_that_the_user_requires_does_not_count() -> None:
    models = InventedModels(
        {"": 1.0, "a": 0.1}, at_bounds="a", known=PriorKnowledge(with_effects=("a",))
    )
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    assert not visited.at_bound(models.fitted(("a",), "first"))  # type: ignore[arg-type]


def test_nothing_is_left_out_where_the_simulations_are_spent() -> None:
    assert reduced({"": 9.0, "a": 5.0}, "ab", replace(EFFORT, cost=1.0)) == []


def backward(
    models: InventedModels, effort: SearchEffort = EFFORT, **policy: Any
) -> BackwardSearch:
    criterion = replace(CRITERION, policy=replace(CRITERION.policy, **policy))
    visited = Visited(models, criterion)  # type: ignore[arg-type]
    return BackwardSearch(models, visited, effort, silent)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("there", "contains", "known", "fitted"),
    [
        ("", {}, PriorKnowledge(), "abc"),
        ("b", {}, PriorKnowledge(), "abc"),
        ("", {}, PriorKnowledge(without_effects=("b",)), "ac"),
        ("", {}, PriorKnowledge(with_effects=("r",)), "abcr"),
        ("a", {}, PriorKnowledge(start_effects=("a",)), "abc"),
        ("", {"a": "b"}, PriorKnowledge(), "ac"),  # b is in a
        ("b", {"a": "b"}, PriorKnowledge(), "bc"),  # a would take b's place
    ],
)
def test_the_first_ordinary_effects_are_fitted_at_once(
    there: str, contains: dict[str, str], known: PriorKnowledge, fitted: str
) -> None:
    models = InventedModels({"": 1.0, "abcdr": 0.9}, contains=contains, known=known)
    base = models.fitted(tuple(there), "first")
    begun = backward(models, together=3).joint.together(base)  # type: ignore[arg-type]
    assert models.done[1] == f"together {fitted}"
    assert "".join(begun.effects) == fitted


@pytest.mark.parametrize(("error", "core"), [(0.1, []), (0.5, ["together abc"])])
def test_the_first_three_are_fitted_alone_where_more_end_above_the_floor(
    error: float, core: list[str]
) -> None:
    models = InventedModels({"": 1.0, "abcd": error})
    backward(models).joint.together(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[1:] == ["together abcd", *core]


@pytest.mark.parametrize(
    ("errors", "richer"),
    [
        ({"": 3.0, "abc": 1.01, "ab": 1.2, "abg": 0.1}, ["together abg"]),
        ({"": 3.0, "abc": 1.01, "ab": 1.02, "abg": 0.1}, []),  # c hardly matters
        ({"": 3.0, "abc": 0.99, "ab": 1.2, "abg": 0.1}, []),  # within ten times the floor with c
    ],
)
def test_a_richer_effect_of_the_command_takes_the_place_of_one_that_matters(
    errors: dict[str, float], richer: list[str]
) -> None:
    """``g`` contains ``c``, and both shape the command."""
    models = InventedModels(errors, contains={"g": "c"}, on_command="cg")
    search = backward(models, ordinary=("a", "b", "c", "g"), together=3)
    begun = search.joint.together(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[1:] == ["together abc", *richer]
    assert "".join(begun.effects) == ("abg" if richer else "abc")


@pytest.mark.parametrize(("alone_deg", "richer"), [(2.9, ["together abg"]), (3.0, [])])
def test_a_richer_effect_of_the_command_that_changes_nothing_alone_is_not_tried(
    alone_deg: float, richer: list[str]
) -> None:
    """What shapes the command shows by itself: fitting it beside five others costs much."""
    errors = {"": 3.0, "abc": 1.01, "ab": 1.2, "abg": 0.1, "g": alone_deg}
    models = InventedModels(errors, contains={"g": "c"}, on_command="cg")
    first = models.fitted((), "first")
    models.fitted(("g",), "single")
    search = backward(models, ordinary=("a", "b", "c", "g"), together=3)
    search.joint.together(first)  # type: ignore[arg-type]
    assert models.done[2:] == ["together abc", *richer]


@pytest.mark.parametrize(
    ("slew_deg", "profile_deg", "fitted"),
    [
        (2.9, 2.4, "abg"),  # 68 % of the squared error
        (2.9, 2.5, "abc"),  # 74 %
        (None, 2.0, "abc"),  # the slew limit was not fitted alone
    ],
)
def test_a_profile_that_alone_leaves_far_less_than_a_slew_limit_is_in_the_first_joint_fit(
    slew_deg: float | None, profile_deg: float, fitted: str
) -> None:
    """``g`` contains ``c``, and both shape the command; k is held in the joint fit alone."""
    alone = {"c": slew_deg or 2.9, "g": profile_deg}
    errors = {"": 3.0, "abc": 0.5, "abg": 0.5, **alone}
    models = InventedModels(errors, contains={"g": "c"}, on_command="cg", k_may_be_held=True)
    models.first()
    for name in ("g",) if slew_deg is None else alone:
        models.fitted((name,), "single")
    linear = models.unloaded()
    done = len(models.done)
    search = backward(models, ordinary=("a", "b", "c", "g"), together=3)
    begun = search.joint.together(linear)  # type: ignore[arg-type]
    assert models.done[done] == f"together {fitted}"
    assert "".join(begun.effects) == fitted
    assert begun.held == ("k",)


@pytest.mark.parametrize(
    ("at_one_gain", "limit"), [(True, "torque_saturation"), (False, "current_limit")]
)
def test_several_gains_put_the_current_limit_in_the_torque_limits_place(
    at_one_gain: bool, limit: str
) -> None:
    ordinary = ("gravity_load", "torque_saturation", "dead_time", "current_limit")
    fitted: list[tuple[str, ...]] = []

    def together(base: Any, names: tuple[str, ...], *limits: float) -> Any:
        fitted.append(tuple(names))
        return base

    models: Any = InventedModels({"": 1.0})
    base = models.fitted((), "first")
    stand_in: Any = SimpleNamespace(
        at_one_gain=at_one_gain,
        known=models.known,
        catalogue={
            name: SimpleNamespace(contains=(), for_several_gains=first, place=Place.DRIVE)
            for name, first in zip(ordinary, (None, None, None, "torque_saturation"), strict=True)
        },
        candidates=lambda base: ordinary,
        work=models.work,
        recordings=models.recordings,
        split=models.split,
        together=together,
    )
    policy = replace(CRITERION.policy, ordinary=ordinary, together=2)
    visited = Visited(models, replace(CRITERION, policy=policy))
    BackwardSearch(stand_in, visited, EFFORT, silent).joint.together(base)
    assert [tuple(names) for names in fitted] == [("gravity_load", limit)]


@pytest.mark.parametrize(("spent", "most_cost"), [(0.0, 45.0), (30.0, 75.0), (60.0, 90.0)])
def test_effects_fitted_at_once_are_varied_for_a_share_of_what_a_search_may_cost(
    spent: float, most_cost: float
) -> None:
    """45 of 100 whatever was spent before, as far as the search goes: to 90."""
    given: list[tuple[object, ...]] = []
    models: Any = SimpleNamespace(
        recordings=(None,),
        work=SimpleNamespace(cost=spent),
        split=SimpleNamespace(mean_s=5.0),
        together=lambda *all_: given.append(all_),
    )
    base: Any = "base"
    SearchEffort(cost=100.0).together(models, base, ("a", "b"), 0.1)
    assert given == [("base", ("a", "b"), 0.1, math.inf, most_cost)]


def test_none_are_fitted_at_once_where_all_are_there_or_nothing_may_be_spent() -> None:
    models = InventedModels({"": 1.0, "abcd": 0.1})
    base = models.fitted(tuple("abcd"), "first")
    assert backward(models).joint.together(base) is base  # type: ignore[arg-type]
    assert models.done == ["first abcd"]
    models = InventedModels({"": 1.0, "abcd": 0.1})
    linear = models.fitted((), "first")
    spent = backward(models, replace(EFFORT, cost=1.0))
    assert spent.joint.together(linear) is linear  # type: ignore[arg-type]
    assert models.done == ["first"]


@pytest.mark.parametrize(
    ("shaped_deg", "limited_deg", "known"),
    [(0.2, 0.5, "bcde"), (0.4, 0.5, "abcd"), (0.2, 0.1, "acdf")],
)
def test_what_was_fitted_at_once_before_is_known_where_all_is_spent(
    shaped_deg: float, limited_deg: float, known: str
) -> None:
    """The best of all with a slew limit, ``a``, with the profile ``e`` that contains it, and with
    the limit ``f`` for several gains in the place of ``b``."""
    errors = {"": 1.0, "abcd": 0.3, "bcde": shaped_deg, "acdf": limited_deg}
    models = InventedModels(
        errors, contains={"e": "a", "f": "b"}, on_command="ae", at_gains={"f": "b"}
    )
    linear = models.fitted((), "first")
    for effects in ("abcd", "bcde", "acdf"):
        models.fitted(tuple(effects), "together")
    policy = SelectionPolicy(ordinary=tuple("abcde"), together=4)
    visited = Visited(models, AcceptanceCriterion(0.1, 0.0, policy))  # type: ignore[arg-type]
    spent = replace(EFFORT, cost=1.0)
    search = BackwardSearch(models, visited, spent, silent)  # type: ignore[arg-type]
    found = search.joint.together(linear)  # type: ignore[arg-type]
    assert "".join(found.effects) == known


@pytest.mark.parametrize(
    ("error", "validation", "varied"),
    [(0.1, 0.1, False), (0.1, 0.5, True), (0.5, 0.5, False)],
)
def test_a_minimum_that_fits_and_does_not_predict_is_varied(
    error: float, validation: float, varied: bool
) -> None:
    errors = {"": 1.0, "abcd": error}
    models = InventedModels(errors, validation_deg={"abcd": validation})
    backward(models).joint.together(models.fitted((), "first"))  # type: ignore[arg-type]
    assert ("vary abcd" in models.done) is varied


def test_further_effects_stay_where_they_lower_the_fitted_error() -> None:
    """``d`` by more than 1 %, ``c`` by less."""
    models = InventedModels({"": 1.0, "ab": 0.5, "abc": 0.4951, "abd": 0.4949})
    rich = backward(models).rich(models.fitted(tuple("ab"), "first"), "abcd")  # type: ignore[arg-type]
    assert "".join(rich.effects) == "abd"
    assert models.done[1:] == ["fit abc", "fit abd"]


def test_a_model_that_has_grown_is_varied_and_then_reduced() -> None:
    models = InventedModels({"": 1.0, "ab": 0.5, "abc": 0.3})
    backward(models, together=2).search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[1:5] == ["together ab", "fit abc", "vary abc", "reduce bc"]
    models = InventedModels({"": 1.0, "ab": 0.5})
    backward(models, together=2).search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert not any(one.startswith("vary") for one in models.done)
    models = InventedModels({"": 1.0, "ab": 0.1})
    backward(models, together=2).search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[1:] == ["together ab", "reduce b", "reduce a"]


@pytest.mark.parametrize(("last", "further"), [(0.3, True), (0.55, False)])
def test_the_best_ranked_is_extended_while_it_becomes_clearly_lower(
    last: float, further: bool
) -> None:
    """By 5 % of the error, penalty of the effect included."""
    models = InventedModels({"": 1.0, "a": 0.6, "b": 0.7, "ab": last, "abc": 0.1})
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    for effects in ("", "a", "b"):
        models.fitted(tuple(effects), "first")
    BeamSearch(models, visited, EFFORT, silent).search()  # type: ignore[arg-type]
    assert ("fit abc" in models.done) is further
    assert "fit ab" in models.done
    assert not any(done.startswith(("sketch +", "sketch b+")) for done in models.done)
    assert models.done.count("sketch a+b") == 1


def searched_up(models: InventedModels, begun: Sequence[str]) -> list[str]:
    """What is fitted from a few models up."""
    for effects in begun:
        models.fitted(tuple(effects), "first")
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    BeamSearch(models, visited, EFFORT, silent).search()  # type: ignore[arg-type]
    return models.done[len(begun) :]


def test_the_best_ranked_and_what_fits_best_with_one_effect_more_are_varied() -> None:
    """``r`` is no ordinary effect: with it a model ranks too low to be varied."""
    done = searched_up(InventedModels({"": 1.0, "a": 0.3, "ab": 0.29}), ("", "a"))
    assert [one for one in done if one.startswith("vary")] == ["vary a", "vary ab"]
    done = searched_up(InventedModels({"": 1.0, "a": 0.3, "ar": 0.29}), ("", "a"))
    assert [one for one in done if one.startswith("vary")] == ["vary a"]


@pytest.mark.parametrize(("varied", "rounds"), [(0.2, 2), (0.29, 1)])
def test_from_a_clearly_lower_minimum_the_search_goes_on(varied: float, rounds: int) -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.3}, varied_deg={"a": varied})
    assert searched_up(models, ("", "a", "b")).count("vary a") == rounds


@pytest.mark.parametrize(
    ("both_deg", "left_deg", "found"),
    [(0.1, 0.5, "ab"), (0.1, 0.1, "a"), (0.3, 0.3, "")],
    ids=["both are needed", "one is enough", "they do not explain"],
)
def test_ordinary_effects_at_once_are_the_answer_where_they_explain(
    both_deg: float, left_deg: float, found: str
) -> None:
    models = InventedModels({"": 1.0, "a": left_deg, "ab": both_deg}, k_may_be_held=True)
    steps = [Step(models.first())]  # type: ignore[arg-type]
    seen = Visited(models, CRITERION)  # type: ignore[arg-type]
    ended = fitted_jointly(steps, seen, EFFORT, silent)
    assert "".join(ended[-1].trial.effects) == found
    assert [step.added for step in ended[1:]] == list(found)
    models = InventedModels({"": 1.0, "ab": 0.1})
    seen = Visited(models, CRITERION)  # type: ignore[arg-type]
    assert fitted_jointly(steps, seen, EFFORT, silent) == steps


def test_what_fits_together_is_reduced_even_if_it_does_not_predict() -> None:
    """All that are fitted at once leave 0.3 deg of the validation data, and two of them 0.1."""
    errors = {"": 1.0, "a": 0.6, "ab": 0.1, "abcd": 0.1}
    ways = {"abcd": 0.3, "abc": 0.3, "abd": 0.3}
    models = InventedModels(errors, validation_deg=ways, k_may_be_held=True)
    steps = [Step(models.first())]  # type: ignore[arg-type]
    seen = Visited(models, CRITERION)  # type: ignore[arg-type]
    ended = fitted_jointly(steps, seen, EFFORT, silent)
    assert ended[-1].trial.effects == ("a", "b")


def test_special_cases_of_the_best_are_tried_whatever_was_tried_before() -> None:
    models = InventedModels({"": 1.0, "a": 0.1, "r": 0.1}, contains={"r": "a"})
    for effects in ((), ("r",)):
        models.fitted(effects, "first")
    best = _simplest(Visited(models, CRITERION))  # type: ignore[arg-type]
    assert best.effects == ("a",)
    assert "fit a" in models.done
