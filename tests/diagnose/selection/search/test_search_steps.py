"""What the wider search fits and where it ends, on tables of invented models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import AcceptanceCriterion, SearchEffort, SelectionPolicy
from servosight.diagnose.selection.search import BackwardSearch, BeamSearch, Visited
from servosight.diagnose.selection.search._wide import _simplest
from servosight.models.core import silent

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


def test_the_way_down_ends_at_two_effects_prices_above_its_cheapest() -> None:
    assert reduced({"": 0.3, "ab": 0.15, "abc": 0.1}, "abc") == [
        "reduce bc",
        "reduce ac",
        "reduce ab",
    ]


def test_nothing_is_left_out_where_the_simulations_are_spent() -> None:
    assert reduced({"": 0.2, "a": 0.1}, "ab", replace(EFFORT, cost=1.0)) == []


@pytest.mark.parametrize(("last", "further"), [(0.3, True), (0.55, False)])
def test_the_cheapest_is_extended_while_it_becomes_clearly_cheaper(
    last: float, further: bool
) -> None:
    """By 5 % of the error, price of the effect included."""
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


def test_the_cheapest_and_what_fits_best_with_one_effect_more_are_varied() -> None:
    """``r`` is no ordinary effect: with it a model is too dear to be varied."""
    done = searched_up(InventedModels({"": 1.0, "a": 0.3, "ab": 0.29}), ("", "a"))
    assert [one for one in done if one.startswith("vary")] == ["vary a", "vary ab"]
    done = searched_up(InventedModels({"": 1.0, "a": 0.3, "ar": 0.29}), ("", "a"))
    assert [one for one in done if one.startswith("vary")] == ["vary a"]


@pytest.mark.parametrize(("varied", "rounds"), [(0.2, 2), (0.29, 1)])
def test_from_a_clearly_lower_minimum_the_search_goes_on(varied: float, rounds: int) -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.3}, varied_deg={"a": varied})
    assert searched_up(models, ("", "a", "b")).count("vary a") == rounds


def test_special_cases_of_the_best_are_tried_whatever_was_tried_before() -> None:
    models = InventedModels({"": 1.0, "a": 0.1, "r": 0.1}, contains={"r": "a"})
    for effects in ((), ("r",)):
        models.fitted(effects, "first")
    best = _simplest(Visited(models, CRITERION))  # type: ignore[arg-type]
    assert best.effects == ("a",)
    assert "fit a" in models.done
