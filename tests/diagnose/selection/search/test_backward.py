"""Where the reduction of a rich model ends before it begins, on tables of invented models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import AcceptanceCriterion, SearchEffort, SelectionPolicy
from servosight.diagnose.selection.search import BackwardSearch, Visited, _backward
from servosight.models.core import silent

ORDINARY = SelectionPolicy(ordinary=("a", "b", "c", "d"), together=2)


def backward(models: InventedModels, ordinary: str = "abcd", core: int = 3) -> BackwardSearch:
    policy = replace(ORDINARY, ordinary=tuple(ordinary), core=core)
    criterion = AcceptanceCriterion(0.1, 0.0, policy)
    visited = Visited(models, criterion)  # type: ignore[arg-type]
    return BackwardSearch(models, visited, SearchEffort(), silent)  # type: ignore[arg-type]


@pytest.mark.parametrize(("effects", "validation_deg", "done"), [
    ("", 0.0, ["fit", "reduce"]), ("ab", 0.99, ["fit", "reduce"]), ("ab", 1.01, []),
    ("abc", 1.01, ["fit"]),
])  # fmt: skip
def test_a_rich_model_is_left_where_it_validates_worse_than_none(
    effects: str, validation_deg: float, done: list[str]
) -> None:
    """The first model errs by 1 deg on validation data, these effects or all of them by more."""
    models = InventedModels(
        {"": 1.0, "ab": 0.3, "abc": 0.2}, validation_deg={effects: validation_deg or 1.0}
    )
    backward(models, "abc").search(models.fitted((), "first"))  # type: ignore[arg-type]
    kinds = [kind for kind in ("fit", "reduce") if any(one.startswith(kind) for one in models.done)]
    assert kinds == done


@pytest.mark.parametrize(
    ("cost", "rich_deg", "done"),
    [
        (5.1, 1.01, ["vary abc", "reduce bc"]),
        (4.9, 1.01, ["reduce b", "reduce a"]),
        (4.9, 0.99, ["reduce bc", "reduce ac"]),
    ],
)
def test_a_rich_model_that_comes_late_and_errs_much_gives_way_to_the_first_effects(
    cost: float, rich_deg: float, done: list[str]
) -> None:
    """Three fits lead to it. Where they are more than 0.6 of what a search may cost, what is left
    would not do to vary and to reduce it; within ten times the floor of 0.1 deg it is reduced."""
    models = InventedModels({"": 9.0, "ab": 3.0, "abc": rich_deg})
    search = replace(backward(models, "abc"), effort=SearchEffort(cost=cost))
    search.search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[: 3 + len(done)] == ["first", "together ab", "fit abc", *done]


@pytest.mark.parametrize(("cost", "reduced"), [(5.1, "reduce bc"), (4.9, "reduce b")])
def test_a_rich_model_that_comes_late_and_errs_much_is_not_fitted_to_its_end(
    cost: float, reduced: str
) -> None:
    """At its end it would leave 0.5 deg, within ten times the floor, for much of what is left."""
    models = InventedModels({"": 9.0, "ab": 3.0, "abc": 1.01}, finished_deg={"abc": 0.5})
    search = replace(backward(models, "abc"), effort=SearchEffort(cost=cost))
    search.search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert next(one for one in models.done if one.startswith("reduce")) == reduced


class OnePlay(InventedModels):
    """``c`` and ``d`` are the same play in two places: with both, the first in the model acts."""

    def error_deg(self, effects: Sequence[str]) -> float:
        both = {"c", "d"} <= set(effects)
        return super().error_deg([one for one in effects if one != "d"] if both else effects)


@pytest.mark.parametrize(("outdone", "instead_deg"), [(False, 0.2), (True, 0.2), (False, 0.7)])
def test_play_is_tried_in_the_place_of_the_same_play_elsewhere(
    outdone: bool, instead_deg: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside play in one place, that in the other one gains nothing."""
    monkeypatch.setattr(_backward, "PLAY", ("c", "d"))
    monkeypatch.setattr(Visited, "is_outdone", lambda *_: outdone)
    models = OnePlay({"": 3.0, "ab": 1.0, "abc": 0.6, "abd": instead_deg})
    rich = backward(models).rich(models.fitted(("a", "b"), "begun"), "cd")  # type: ignore[arg-type]
    assert "".join(rich.effects) == ("abd" if instead_deg < 0.6 else "abc")


@pytest.mark.parametrize(("alone_deg", "fitted"), [(3.0, False), (2.0, True)])
def test_what_shapes_the_command_and_gains_nothing_alone_is_in_no_rich_model(
    alone_deg: float, fitted: bool
) -> None:
    """A motion profile, ``c``, that contains a slew limit, ``a``: its simulations cost most."""
    errors = {"": 3.0, "ab": 1.0, "c": alone_deg, "bc": 0.9}
    models = InventedModels(errors, contains={"c": "a"}, on_command="ac")
    models.first()
    models.fitted(("c",), "single")
    begun = models.fitted(("a", "b"), "begun")
    rich = backward(models).rich(begun, "abc")  # type: ignore[arg-type]
    assert ("c" in rich.effects) is fitted


@pytest.mark.parametrize(("single_deg", "at_bounds", "goes_on"), [
    (0.19, "", False), (0.21, "", True), (0.19, "z", True),
])  # fmt: skip
def test_a_rich_model_is_left_where_a_smaller_one_errs_less(
    single_deg: float, at_bounds: str, goes_on: bool
) -> None:
    """All ordinary effects leave 0.2 deg; one that is not among them leaves less, or at a bound."""
    errors = {"": 1.0, "z": single_deg, "ab": 0.3, "abc": 0.2}
    models = InventedModels(errors, at_bounds=at_bounds)
    models.fitted(("z",), "single")
    backward(models, "abc").search(models.fitted((), "first"))  # type: ignore[arg-type]
    assert any(one.startswith("reduce") for one in models.done) is goes_on
    assert any(one.startswith("vary") for one in models.done) is goes_on


def test_what_gains_nothing_in_a_sketch_is_not_fitted_beside_more_than_a_smaller_model_errs() -> (
    None
):
    """``ab`` leave 0.3 deg and ``z`` alone 0.2; beside them ``c`` gains and ``d`` does not."""
    errors = {"": 1.0, "z": 0.2, "ab": 0.3, "abc": 0.25, "d": 1.0}
    fitted = {}
    for single in (("z",), ()):
        models = InventedModels(errors)
        models.fitted(single, "single")
        backward(models).search(models.fitted((), "first"))  # type: ignore[arg-type]
        fitted[single] = [one for one in models.done if one.startswith(("fit", "sketch"))]
    assert fitted["z",] == ["sketch ab+c", "fit abc", "sketch abc+d"]
    assert fitted[()] == ["fit abc", "fit abcd"]


@pytest.mark.parametrize(
    ("single_deg", "released_deg", "validation_deg", "ended"),
    [(0.2, 0.3, {}, True), (0.2, 0.1, {}, False), (1.0, 0.3, {"ab": 1.1}, True),
     (1.0, 0.3, {}, False)],
    ids=["smaller errs less", "with another k it does not", "chance", "neither"],
)  # fmt: skip
def test_no_other_k_is_sought_where_the_ordinary_effects_are_hopeless_with_either(
    single_deg: float, released_deg: float, validation_deg: dict[str, float], ended: bool
) -> None:
    """With k held ``ab`` leave 0.4 deg, and ``z`` alone some more or less."""
    models = InventedModels(
        {"": 1.0, "z": single_deg, "ab": released_deg},
        held_deg={"": 1.0, "ab": 0.4, "z": 1.0},
        validation_deg=validation_deg,
        k_may_be_held=True,
    )
    models.fitted(("z",), "single")
    models.first()
    search = backward(models, "ab")
    assert search.search_unloaded() is ended
    assert "free ab" in models.done


@pytest.mark.parametrize(("core_deg", "varied"), [(0.9, False), (1.1, True)])
def test_the_core_alone_is_fitted_from_variations_far_above_the_floor(
    core_deg: float, varied: bool
) -> None:
    """Ten times the floor of 0.1 deg is far; nearer to it, it has been varied with its fit."""
    models = InventedModels({"": 3.0, "a": core_deg, "ab": core_deg})
    backward(models, core=1).joint.together(models.fitted((), "first"))  # type: ignore[arg-type]
    assert models.done[:3] == ["first", "together ab", "together a"]
    assert ("vary a" in models.done) == varied


@pytest.mark.parametrize(("rich_deg", "reduced"), [(0.99, True), (1.01, False)])
def test_a_model_near_the_floor_is_reduced_though_all_is_spent(
    rich_deg: float, reduced: bool
) -> None:
    """The floor is 0.1 deg: a model within ten times that has what the data show, and what it can
    do without is left out, for 0.3 of what a search may cost."""
    models = InventedModels({"": 3.0, "abc": rich_deg, "ab": rich_deg})
    rich = models.fitted(("a", "b", "c"), "rich")
    effort = SearchEffort(cost=models.work.cost)
    replace(backward(models, "abc"), effort=effort).reduce(rich)  # type: ignore[arg-type]
    assert any(one.startswith("reduce") for one in models.done) is reduced
