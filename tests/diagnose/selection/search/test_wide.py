"""Where the search among whole sets of effects ends, on tables of invented models."""

from __future__ import annotations

from typing import Any

import pytest
from support.invented_models import InventedModels, steps_of

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SearchEffort,
    SelectionPolicy,
)
from servosight.diagnose.selection.search import (
    Visited,
    completed,
    fitted_jointly,
    searched_widely,
)
from servosight.diagnose.selection.search._wide import steps_to
from servosight.models.core import silent

CRITERION = AcceptanceCriterion(0.1, 0.0, SelectionPolicy(ordinary=("a", "b", "c", "d")))
EFFORT = SearchEffort(beam=1)


def visited(models: InventedModels) -> Visited:
    return Visited(models, CRITERION)  # type: ignore[arg-type]


def effects_of(steps: list[Any]) -> list[str]:
    return ["".join(step.trial.effects) for step in steps]


def widely(models: InventedModels, *begun: str) -> list[Any]:
    """The steps after a search behind those to ``begun``."""
    steps = steps_of(models.first(), *(models.fitted(tuple(one), "step") for one in begun))
    models.done.clear()
    return searched_widely(steps, visited(models), EFFORT, silent)


def test_the_best_of_all_that_was_fitted_is_the_answer() -> None:
    models = InventedModels({"": 1.0, "c": 0.6, "ab": 0.1})
    ended = widely(models, "c")
    assert effects_of(ended)[-1] == "ab"
    assert ended[0].added is None
    assert {step.added for step in ended[1:]} == {"a", "b"}


def test_the_steps_stay_where_nothing_lower_is_accepted() -> None:
    """``ab`` is best-ranked and not accepted, as ``b`` rests on a bound; ``c`` is accepted and
    ranks between ``ab`` and ``a``."""
    models = InventedModels(
        {"": 1.0, "a": 0.6, "c": 0.5, "ab": 0.2}, at_bounds="b", promised=dict.fromkeys("acd", 0.0)
    )
    models.fitted(("c",), "before")
    assert effects_of(widely(models, "a", "ab")) == ["", "a", "ab"]


@pytest.mark.parametrize(
    ("changes", "begun", "together"),
    [
        ({}, "", ["together abc"]),
        ({}, "ab", []),  # at the floor already
        ({"k_may_be_held": True, "held_deg": {"abc": 0.1}}, "", ["together abc"]),
    ],
    ids=["from the linear model", "at the floor", "with k held"],
)
def test_a_rich_model_is_reduced_once(
    changes: dict[str, Any], begun: str, together: list[str]
) -> None:
    models = InventedModels({"": 1.0, "ab": 0.1, "c": 1.0}, **changes)
    if begun:
        models.fitted(tuple(begun), "before")
    assert effects_of(widely(models))[-1] == "ab"
    assert [one for one in models.done if one.startswith("together")] == together
    held = {one.held for one in models.trials.values() if len(one.effects) == 3}
    assert held == ({("k",)} if changes else {()} if together else set())


def test_a_k_that_the_data_ask_for_is_fitted_in_a_rich_model_too() -> None:
    """With k held nothing explains the data."""
    errors = {"": 1.0, "ab": 0.1, "c": 1.0}
    held = {"": 1.0, "a": 1.0, "b": 1.0, "c": 1.0} | dict.fromkeys(("ab", "ac", "bc", "abc"), 0.9)
    models = InventedModels(errors, k_may_be_held=True, held_deg=held)
    ended = widely(models)
    assert effects_of(ended)[-1] == "ab"
    assert ended[-1].trial.held == ()


def test_a_rich_model_is_fitted_where_the_best_ranked_is_not_at_the_floor() -> None:
    """The next best-ranked is: ``r`` is no ordinary effect, and its penalty outweighs its error."""
    models = InventedModels({"": 1.0, "a": 0.115, "r": 0.1})
    models.fitted(("a",), "before")
    models.fitted(("r",), "before")
    seen = visited(models)
    assert ["".join(one.effects) for one in seen.ranked()] == ["a", "r"]
    widely(models)
    assert "together a" in models.done


def test_the_joint_fit_says_what_it_is() -> None:
    shown: list[tuple[str, int, int | None]] = []

    def progress(stage: str, done: int, total: int | None = None) -> None:
        shown.append((stage, done, total))

    models = InventedModels({"": 1.0, "a": 0.1}, k_may_be_held=True)
    fitted_jointly(steps_of(models.first()), visited(models), EFFORT, progress)
    assert shown[0] == ("ordinary effects together with k held", 0, 1)


# What is completed once the cost is spent


@pytest.mark.parametrize(
    ("errors", "begun", "ended", "fitted"),
    [
        ({"": 1.0, "ab": 0.5, "abcd": 0.1}, "ab", "abcd", True),
        ({"": 1.0, "ab": 0.5, "abc": 0.1}, "ab", "abc", True),
        ({"": 1.0, "ab": 0.5, "abcd": 0.48}, "ab", "ab", True),
        ({"": 1.0, "ab": 0.1, "abc": 0.1}, "abc", "ab", False),
        ({"": 1.0, "ab": 0.15, "abcd": 0.1}, "ab", "ab", False),
        ({"": 1.0, "abcd": 0.1}, "", "", False),
        ({"": 9.0, "ab": 1.1, "abcd": 0.1}, "ab", "ab", False),
        ({"": 1.0, "ar": 0.5, "abcdr": 0.1}, "ar", "ar", False),
    ],
    ids=[
        "two lack",
        "one lacks",
        "nothing gains",
        "one too many",
        "near the floor",
        "no effects",
        "beyond ten floors",
        "an effect that few have",
    ],
)
def test_the_ordinary_effects_that_an_answer_lacks_are_fitted_behind_it(
    errors: dict[str, float], begun: str, ended: str, fitted: bool
) -> None:
    """And those that it does not need are left out at the floor of 0.1 deg."""
    models = InventedModels(errors | {"c": 1.0, "d": 1.0})
    steps = steps_of(models.first(), *([models.fitted(tuple(begun), "step")] if begun else ()))
    models.done.clear()
    found = completed(steps, visited(models), EFFORT, silent)
    assert effects_of(found)[-1] == ended
    assert [one for one in models.done if "together" in one] == ["together abcd"] * fitted
    if begun == ended:
        assert found == steps


@pytest.mark.parametrize(("known_deg", "fitted"), [(0.6, True), (0.5, False)])
def test_what_an_answer_lacks_is_not_fitted_again_from_a_minimum_that_is_as_low(
    known_deg: float, fitted: bool
) -> None:
    errors = {"": 1.0, "ab": 0.5, "abcd": 0.1, "c": 1.0, "d": 1.0}
    models = InventedModels(errors, varied_deg={"abcd": known_deg})
    steps = steps_of(models.first(), models.fitted(tuple("ab"), "step"))
    models.varied(models.fitted(tuple("abcd"), "before"), 0.0, 1.0)
    found = completed(steps, visited(models), EFFORT, silent)
    assert effects_of(found)[-1] == ("abcd" if fitted else "ab")


# The steps to a model


def test_steps_lead_to_a_model_by_one_effect_each_along_the_best_ranked_way() -> None:
    models = InventedModels({"": 1.0, "a": 0.9, "b": 0.5, "ab": 0.2, "c": 0.7})
    steps = steps_of(models.first(), models.fitted(("c",), "step"), models.fitted(("a",), "step"))
    found = steps_to(steps, visited(models), models.fitted(tuple("ab"), "best"))  # type: ignore[arg-type]
    assert effects_of(found) == ["", "b", "ab"]
    assert [step.added for step in found] == [None, "b", "a"]
    assert found[0] is steps[0]


def test_steps_that_end_at_the_model_stay() -> None:
    models = InventedModels({"": 1.0, "a": 0.5, "b": 0.6, "ab": 0.2})
    trials = [models.fitted(tuple(one), "step") for one in ("", "b", "ab")]
    steps = steps_of(*trials)
    assert steps_to(steps, visited(models), trials[-1]) == steps  # type: ignore[arg-type]
    assert effects_of(steps_to(steps, visited(models), trials[1])) == ["", "b"]  # type: ignore[arg-type]


def test_the_first_model_itself_is_one_step() -> None:
    models = InventedModels({"": 1.0, "a": 0.5})
    steps = steps_of(models.first(), models.fitted(("a",), "step"))
    assert effects_of(steps_to(steps, visited(models), steps[0].trial)) == [""]


def test_no_step_leads_to_a_model_without_what_the_first_has() -> None:
    models = InventedModels(
        {"": 1.0, "a": 0.5, "ab": 0.4, "b": 0.3}, known=PriorKnowledge(start_effects=("a",))
    )
    steps = steps_of(models.first(), models.fitted(tuple("ab"), "step"))
    best = models.fitted(("b",), "best")
    assert steps_to(steps, visited(models), best) == steps  # type: ignore[arg-type]
