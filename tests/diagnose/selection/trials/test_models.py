"""Which fits a selection asks for and what it keeps of them, with fits that cost no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.counted_fits import EFFECTS, Fits, recording, selection, solution

from servosight.diagnose.selection import ModelSelection, Split
from servosight.diagnose.selection.trials import _models
from servosight.identify.fit import Solution
from servosight.identify.problem import Problem


def test_a_problem_has_its_effects_in_the_order_of_the_catalogue() -> None:
    models = selection(fixed={"xi": 0.7})
    problem = models.problem(("backlash", "dead_time"))
    assert problem.effects == ("dead_time", "backlash")
    assert dict(problem.held) == {"xi": 0.7}
    assert dict(models.problem((), {"k": 1.0}).held) == {"k": 1.0}


def test_the_linear_model_is_fitted_once_for_what_is_held(fits: Fits) -> None:
    models = selection()
    first = models.linear()
    assert models.linear() is first
    assert models.linear({"k": 1.0}) is not first
    assert fits.asked == [("polish", ()), ("polish", ())]


@pytest.mark.parametrize("k", [0.8, -0.8])
def test_k_is_held_at_one_with_the_sign_of_the_motion(fits: Fits, k: float) -> None:
    held = selection(k).unloaded()
    assert held is not None
    assert dict(held.fit.problem.held) == {"k": np.sign(k)}


def test_a_k_that_the_user_holds_is_left(fits: Fits) -> None:
    assert selection(fixed={"k": 1.1}).unloaded() is None
    assert fits.asked == []


@pytest.mark.parametrize(
    ("known", "fitted"),
    [
        ({"with_effects": ("backlash", "dead_zone")}, [("backlash",), ("backlash", "dead_zone")]),
        (
            {"start_effects": ("backlash",), "with_effects": ("dead_zone",)},
            [("backlash", "dead_zone")],
        ),
    ],
    ids=["required", "started from a model"],
)
def test_what_is_known_is_added_one_by_one(
    fits: Fits, monkeypatch: pytest.MonkeyPatch, known: dict[str, Any], fitted: list[Any]
) -> None:
    """Behind the effects of the model to start from, which are fitted from its values."""
    asked: list[tuple[str, set[str]]] = []

    def started(problem: Problem, fit: Solution, values: Any) -> Solution:
        asked.append(("start", set(problem.effects)))
        return solution(problem)

    def extended(problems: Sequence[Problem], fit: Solution) -> Solution:
        asked.extend(("extend", set(problem.effects)) for problem in problems)
        return solution(problems[-1])

    monkeypatch.setattr(_models, "started", started)
    monkeypatch.setattr(_models, "extended_by_each", extended)
    models = selection(**known)
    found = models.first()
    begun = [("start", {"backlash"})] if "start_effects" in known else []
    assert asked == [*begun, *(("extend", set(one)) for one in fitted)]
    assert set(found.effects) == {"backlash", "dead_zone"}
    assert models.first() is models.opening() is found
    assert asked == [*begun, *(("extend", set(one)) for one in fitted)]


def test_without_knowledge_the_user_sees_a_k_that_fits(fits: Fits) -> None:
    sensor = replace(recording(), side="sensor")
    models = ModelSelection(Split.of([sensor]), EFFECTS)
    assert models.first().held == ("k",)
    assert models.opening().held == ()


def test_candidates_are_neither_there_nor_special_cases_nor_ruled_out(fits: Fits) -> None:
    models = selection(without_effects=("backlash",))
    linear = set(models.candidates(models.linear()))
    assert linear == set(EFFECTS) - {"backlash"}
    stribeck = models.extended(models.linear(), "stribeck_friction")
    assert set(models.candidates(stribeck)) == linear - {"stribeck_friction", "coulomb_friction"}


def test_an_effect_takes_the_place_of_its_special_case_and_keeps_what_is_held(fits: Fits) -> None:
    models = selection()
    base = models.extended(models.linear({"k": 1.0}), "coulomb_friction")
    base = models.extended(base, "backlash")
    assert models.with_effect(base, "dead_time").effects == (
        "dead_time",
        "coulomb_friction",
        "backlash",
    )
    larger = models.with_effect(base, "stribeck_friction")
    assert larger.effects == ("stribeck_friction", "backlash")
    assert dict(larger.held) == {"k": 1.0}


def test_a_fit_is_screened_once(fits: Fits, monkeypatch: pytest.MonkeyPatch) -> None:
    screened: list[list[str]] = []

    def behind(fit: Solution, names: list[str], problems: Sequence[Problem]) -> object:
        screened.append(names)
        assert [set(problem.effects) - set(fit.problem.effects) for problem in problems] == [
            {name} for name in names
        ]
        return object()

    monkeypatch.setattr(_models.Screen, "behind", behind)
    models = selection()
    linear = models.linear()
    assert models.screen(linear) is models.screen(linear)
    assert screened == [models.candidates(linear)]


def test_one_effect_is_left_out_and_nothing_fitted(fits: Fits) -> None:
    models = selection()
    base = models.extended(models.extended(models.linear(), "backlash"), "dead_time")
    before = len(fits.asked)
    assert models.without(base, "dead_time").effects == ("backlash",)
    assert len(fits.asked) == before


def test_models_are_alike_where_the_same_is_held(fits: Fits) -> None:
    models = selection()
    free, held = models.linear(), models.linear({"k": 1.0})
    more = models.extended(held, "backlash")
    assert models.alike(free) == [free]
    assert models.alike(more) == [held, more]


def test_other_parameters_are_held_with_all_other_values_as_they_are(fits: Fits) -> None:
    models = selection(k=0.8)
    free = models.linear()
    asked = list(fits.asked)
    held = models.holding(free, {"k": 1.0})
    assert dict(held.fit.problem.held) == {"k": 1.0}
    values, before = (one.fit.problem.values(one.fit.outcome.point) for one in (held, free))
    assert values == {**before, "k": 1.0}
    assert fits.asked == asked


@pytest.mark.parametrize(("times", "allowed"), [(1.0, 150), (4.0, 150), (12.0, 50)])
def test_a_fit_without_an_effect_is_shorter_where_its_simulations_are_costly(
    monkeypatch: pytest.MonkeyPatch, fits: Fits, times: float, allowed: int
) -> None:
    """Up to four times the usual cost it has all of its simulations, at twelve times a third."""
    models, budgets = selection(), []
    both = models.judge(solution(models.problem(("dead_time", "backlash"))))
    models.work.simulations, models.work.cost = 100, 200.0

    def relative_cost(problem: Problem, fit: Solution) -> Any:
        start = solution(problem).outcome.point
        models.work.simulations, models.work.cost = 102, 200.0 + 2.0 * 2.0 * times
        return start

    def polish(problem: Problem, starts: Sequence[Any], budget: int) -> Solution:
        budgets.append(budget)
        return solution(problem, starts[0])

    monkeypatch.setattr(_models, "point_less", relative_cost)
    monkeypatch.setattr(_models, "polish", polish)
    models.reduced(both, "backlash", 150)
    assert budgets == [allowed]


@pytest.mark.parametrize(("error_deg", "ended"), [(0.51, False), (0.49, True)])
def test_a_fit_without_an_effect_goes_on_unless_it_errs_five_times_as_much(
    monkeypatch: pytest.MonkeyPatch, error_deg: float, ended: bool
) -> None:
    smaller, larger = (
        SimpleNamespace(score=SimpleNamespace(train_rmse_deg=one)) for one in (error_deg, 0.1)
    )
    monkeypatch.setattr(ModelSelection, "reduced", lambda *_: smaller)
    monkeypatch.setattr(ModelSelection, "finished", lambda *_: "ended")
    found = selection().reduced_enough(larger, "backlash")  # type: ignore[arg-type]
    assert found == ("ended" if ended else smaller)
