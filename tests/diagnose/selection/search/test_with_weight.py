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


def test_a_weight_takes_the_place_of_a_k_at_a_lower_penalised_error() -> None:
    found, models = last_of({"aw": 0.12, "w": 1.4})
    assert found == "aw"
    assert models.done[1:3] == ["hold a", "fit aw"]


def test_it_does_not_where_the_penalised_error_is_no_lower() -> None:
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


def test_a_weight_and_what_such_a_k_has_hidden_take_the_place_of_what_made_up_for_it() -> None:
    """``a`` is no part of the servo; of two effects the one goes which the error needs least."""
    found, models = last_of({"aw": 0.5, "w": 1.0, "dw": 0.12, "aew": 0.5, "adw": 0.12})
    assert found == "dw"
    assert "fit adw" not in models.done


@pytest.mark.parametrize(
    "changes",
    [
        {"k_may_be_held": False},
        {"begun": HELD},
        {"known": PriorKnowledge(without_effects=("w",))},
    ],
)
def test_no_weight_is_tried(changes: dict[str, Any]) -> None:
    """Where k is held already or is the user's, or where a weight is ruled out."""
    found, models = last_of({"aw": 0.12, "w": 1.4}, **changes)
    assert found == "a"
    assert not [one for one in models.done if one.startswith("fit")]


@pytest.mark.parametrize(
    ("held_deg", "changes", "found"),
    [
        (0.12, {}, "gw"),
        (0.45, {}, "aw"),  # its penalty is higher by a parameter less than a k adds
        (0.12, {"contains": {}}, "aw"),
        (0.12, {"known": PriorKnowledge(without_effects=("g",))}, "aw"),
        (0.12, {"validation_deg": {"aw": 0.1}}, "aw"),  # explains the data
    ],
    ids=["taken", "no lower", "nothing contains it", "ruled out", "explained"],
)
def test_an_effect_that_contains_one_takes_the_place_of_it_and_of_a_k(
    held_deg: float, changes: dict[str, Any], found: str
) -> None:
    """``g`` contains ``a``. The weight is there, so it is not a weight that such a k stands for."""
    models = InventedModels(
        {"": 1.0, "a": 1.0, "aw": 0.4, "g": 1.0},
        held_deg={"": 1.5, "w": 1.4, "g": 1.4, "aw": 0.9, "gw": held_deg},
        **{"contains": {"g": "a"}, "usual": {"w": Usual.WEIGHT}, "k_may_be_held": True, **changes},
    )
    steps = steps_of(models.first(), models.fitted(("a", "w"), "step"))
    last = with_weight(steps, visited(models), SearchEffort())[-1].trial
    assert "".join(last.effects) == found
    assert last.held == (HELD if found == "gw" else ())


def test_a_catalogue_without_further_effects_ends_at_the_weight() -> None:
    known = PriorKnowledge(without_effects=("d", "e"))
    found, models = last_of({"aw": 0.41, "w": 1.4}, known=known)
    assert found == "a"
    assert [one for one in models.done if one.startswith("fit")] == ["fit aw", "fit w", "fit aw"]


def explained(held: dict[str, float], **changes: Any) -> tuple[str, list[str]]:
    """The effects at the end and what was fitted, where ``ae`` and a fitted k explain the data."""
    models = InventedModels(
        {"": 1.0, "ae": 0.105, "w": 1.0},
        held_deg={"": 1.5, "a": 1.2, "e": 1.2, "ae": 0.6, "w": 1.4, **held},
        usual={"w": Usual.WEIGHT},
        **{"k_may_be_held": True, **changes},
    )
    steps = steps_of(models.first(), models.fitted(("a", "e"), "step"))
    models.done.clear()
    found = with_weight(steps, visited(models), SearchEffort())
    return "".join(found[-1].trial.effects), [one for one in models.done if "fit" in one]


def test_a_weight_takes_the_place_of_a_k_and_of_the_effect_that_made_up_for_it() -> None:
    """Only the exchange that fits best is fitted to its end."""
    found, fitted = explained({"aw": 0.1, "ew": 0.8})
    assert found == "aw"
    assert fitted == ["fit aw"]


def test_a_weight_takes_the_place_of_a_k_alone_where_the_noise_tells_them_apart() -> None:
    """10 of log-likelihood are asked for; 1000 samples give 48 for 0.100 deg, 0.0 for 0.105."""
    for beside_deg, found in ((0.1, "aew"), (0.105, "ae")):
        assert explained({"aw": 0.3, "ew": 0.8, "aew": beside_deg})[0] == found


@pytest.mark.parametrize("error_deg", [0.105, 0.3])
def test_no_weight_takes_an_effects_place_where_it_fits_no_better(error_deg: float) -> None:
    """Though its penalty is lower by an effect and a k: at the floor the noise decides."""
    assert explained({"aw": error_deg, "ew": 0.8, "aew": error_deg})[0] == "ae"


def test_no_weight_takes_the_place_of_an_effect_that_was_known_before() -> None:
    known = PriorKnowledge(with_effects=("e",))
    assert explained({"aw": 0.1, "ew": 0.8, "aew": 0.105}, known=known)[0] == "ae"


def test_data_that_are_explained_with_the_validation_samples_are_explained() -> None:
    """The weight takes the place of ``e``; beside it, where it does as well, it is not tried."""
    whole = {"validation_deg": {"ae": 0.3}, "explained_with_validation": ("ae",)}
    found, fitted = explained({"aw": 0.1, "aew": 0.1, "ew": 0.8}, **whole)
    assert (found, "fit aew" in fitted) == ("aw", False)
