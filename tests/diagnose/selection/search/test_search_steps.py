"""What the wider search fits and where it ends, on tables of invented models."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import AcceptanceCriterion, SearchEffort, SelectionPolicy
from servosight.diagnose.selection.search import BackwardSearch, BeamSearch, Visited
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
    assert reduced({"": 0.2, "a": 0.1}, "ab", replace(EFFORT, simulations=1)) == []


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
