"""A weight with k held at 1 in the place of another k, on tables of invented models."""

from __future__ import annotations

from typing import Any

import pytest
from support.invented_models import HELD, InventedModels, steps_of, visited

from servosight.diagnose.selection import PriorKnowledge, SearchEffort
from servosight.diagnose.selection.search import with_weight
from servosight.models.effects import Usual


def last_of(
    held: dict[str, float], begun: tuple[str, ...] = (), **changes: Any
) -> tuple[str, InventedModels]:
    """The effects at the end, where ``a`` and a fitted k leave 0.4 deg, ten times the floor.

    ``held`` are errors with k held at 1, where ``w`` is a weight.
    """
    models = InventedModels(
        {"": 1.0, "a": 0.4, "w": 1.0, "d": 1.0, "e": 1.0},
        held_deg={"": 1.5, "a": 0.9, **held},
        usual={"w": Usual.WEIGHT},
        **{"k_may_be_held": True, **changes},
    )
    steps = steps_of(models.first(), models.fitted(("a",), "step", begun))
    models.done.clear()
    found = with_weight(steps, visited(models), SearchEffort())
    return "".join(found[-1].trial.effects), models


def test_a_weight_takes_the_place_of_a_k_at_a_lower_price() -> None:
    found, models = last_of({"aw": 0.12, "w": 1.4})
    assert found == "aw"
    assert models.done[1:3] == ["hold a", "fit aw"]


def test_it_does_not_where_the_price_is_no_lower() -> None:
    """As low an error alone is no reason: nothing tells one from the other."""
    assert last_of({"aw": 0.4, "w": 1.4, "adw": 0.4, "aew": 0.4})[0] == "a"


def test_what_such_a_k_has_hidden_as_well_is_tried_beside_the_weight() -> None:
    found, models = last_of({"aw": 0.41, "w": 1.4, "adw": 0.12, "dw": 1.0, "ad": 0.8})
    assert found == "adw"
    assert {"fit adw", "fit aew"} <= set(models.done)


def test_nothing_is_tried_beside_a_weight_that_fits_worse_than_the_k() -> None:
    """Bound: 1.03 times the error with k fitted, as for an effect that contains another."""
    for error, tried in ((0.411, True), (0.413, False)):
        _, models = last_of({"aw": error, "w": 1.4, "adw": 0.12, "aew": 0.5})
        assert ("fit adw" in models.done) is tried


@pytest.mark.parametrize(
    "changes",
    [
        {"k_may_be_held": False},
        {"begun": HELD},
        {"explained_with_validation": ("a",)},
        {"known": PriorKnowledge(without_effects=("w",))},
    ],
)
def test_no_weight_is_tried(changes: dict[str, Any]) -> None:
    """Where k is held already, is the user's, the data are explained, or a weight is ruled out."""
    found, models = last_of({"aw": 0.12, "w": 1.4}, **changes)
    assert found == "a"
    assert not [one for one in models.done if one.startswith("fit")]


def test_a_catalogue_without_further_effects_ends_at_the_weight() -> None:
    known = PriorKnowledge(without_effects=("d", "e"))
    found, models = last_of({"aw": 0.41, "w": 1.4}, known=known)
    assert found == "a"
    assert [one for one in models.done if one.startswith("fit")] == ["fit aw"]
