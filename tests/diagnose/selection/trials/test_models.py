"""Which fits a selection asks for and what it keeps of them, with fits that cost no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.residuals import TEST, VALIDATION
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    SelectionPolicy,
    Split,
    Trial,
)
from servosight.diagnose.selection.trials import _models
from servosight.identify.fit import Solution
from servosight.identify.problem import Problem
from servosight.identify.search import StopReason
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(200) / 50.0
COMMAND_DEG = 20.0 * np.sin(TIME_S)
EFFECTS = catalogue()


def recording(k: float = 1.0, name: str = "log") -> Recording:
    return Recording(name, TIME_S, COMMAND_DEG, TIME_S, k * COMMAND_DEG)


def solution(problem: Problem, point: Array | None = None, cost: float | None = None) -> Solution:
    """An end that cost a single simulation: the lower, the more effects there are."""
    if point is None:
        point = np.clip(np.zeros(len(problem.coordinates)), *problem.bounds)
    found = Solution.at(problem, point)
    cost = 1.0 / (1.0 + len(problem.effects)) if cost is None else cost
    return replace(found, outcome=replace(found.outcome, cost=cost))


@dataclass
class Fits:
    """What was asked for, in order, and the costs with which fits end where it is not the rule."""

    asked: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)
    starts: list[Any] = field(default_factory=list)
    cost: float | None = None

    def polish(self, problem: Problem, starts: Sequence[Array], budget: int = 0) -> Solution:
        self.asked.append(("polish", problem.effects))
        return solution(problem, starts[0], self.cost)

    def fit_effects(
        self, problem: Problem, base: Solution, sketch: Solution | None, budget: int
    ) -> Solution:
        self.asked.append(("fit", problem.effects))
        self.starts.append(sketch)
        return solution(problem, cost=self.cost)

    def sketch_effects(self, problem: Problem, base: Solution) -> Solution:
        self.asked.append(("sketch", problem.effects))
        return solution(problem)

    def search_effects(self, problem: Problem, base: Solution) -> Solution:
        self.asked.append(("search", problem.effects))
        return solution(problem, cost=self.cost)


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> Fits:
    """In the place of the four ways to fit."""
    found = Fits()
    for name in ("polish", "fit_effects", "sketch_effects", "search_effects"):
        monkeypatch.setattr(_models, name, getattr(found, name))
    return found


def selection(k: float = 1.0, **known: Any) -> ModelSelection:
    return ModelSelection(Split.of([recording(k)]), EFFECTS, PriorKnowledge(**known))


def out_of_budget(trial: Trial) -> Trial:
    stopped = replace(trial.fit.outcome.stopped, reason=StopReason.BUDGET)
    return replace(
        trial, fit=replace(trial.fit, outcome=replace(trial.fit.outcome, stopped=stopped))
    )


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


def test_a_fit_is_made_once_from_a_sketch_and_once_without(fits: Fits) -> None:
    models = selection()
    linear = models.linear()
    sketch = models.sketched(linear, "backlash")
    for _ in range(2):
        models.extended(linear, "backlash", sketch)
        models.extended(linear, "backlash")
    assert [way for way, _ in fits.asked] == ["polish", "sketch", "fit", "fit"]
    assert fits.starts == [sketch.fit, None]
    assert sketch.key not in models.trials or models.trials[sketch.key] is not sketch


def test_only_a_fit_whose_budget_was_spent_goes_on(fits: Fits) -> None:
    models = selection()
    trial = models.extended(models.linear(), "backlash")
    assert models.finished(trial) is trial
    assert ("polish", ("backlash",)) not in fits.asked
    fits.cost = 0.1
    ended = models.finished(out_of_budget(trial))
    assert fits.asked[-1] == ("polish", ("backlash",))
    assert ended.fit.outcome.cost == 0.1


@pytest.mark.parametrize(("cost", "better"), [(0.4, True), (0.5, False), (0.6, False)])
def test_more_starts_count_where_they_lead_lower(fits: Fits, cost: float, better: bool) -> None:
    models = selection()
    trial = models.extended(models.linear(), "backlash")
    assert trial.fit.outcome.cost == 0.5
    fits.cost = cost
    trial = replace(trial)  # no other trial is this one
    found = models.searched(models.linear(), trial, "backlash")
    assert fits.asked[-1] == ("search", ("backlash",))
    assert (found is not trial) is better
    assert found.fit.outcome.cost == min(cost, 0.5)


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


def test_a_model_is_fitted_to_validation_samples_once(fits: Fits) -> None:
    models = selection()
    linear = models.linear()
    whole = models.whole(linear)
    assert models.whole(linear) is whole
    fitted, seen = (int(one.fit.problem.masks[0].sum()) for one in (linear, whole))
    assert seen > fitted
    assert len(fits.asked) == 2


def test_a_model_explains_all_data_at_the_floor(fits: Fits) -> None:
    models = selection()
    rmse_deg = models.whole(models.linear()).fit.rmse_deg
    policy = SelectionPolicy(explained=1.0)
    for factor, explained in ((1.0, True), (0.999, False)):
        criterion = AcceptanceCriterion(factor * rmse_deg, 0.0, policy)
        assert models.explained_whole(models.linear(), criterion) is explained


def test_recordings_that_validate_are_not_fitted(fits: Fits) -> None:
    models = ModelSelection(Split.of([recording()], [recording(name="other")]), EFFECTS)
    linear = models.linear()
    assert [one.recording.name for one in linear.judged] == ["log", "other"]
    assert models.whole(linear) is linear
    assert not models.explained_whole(linear, AcceptanceCriterion(1e6, 0.0))
    assert len(fits.asked) == 1


def test_a_recording_that_validates_is_placed_by_the_samples_that_choose(
    fits: Fits, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its bias and its first motion; those of one for the test alone by all of it."""
    masks: list[Any] = []

    def carried(one: Recording, catalogue: Any, effects: Any, fit: Any, mask: Any = None) -> Array:
        masks.append(mask)
        return one.angle_deg

    monkeypatch.setattr(_models, "carried_over", carried)
    split = Split.of([recording()], [recording(name="other")], [recording(name="test")])
    models = ModelSelection(split, EFFECTS)
    judged = models.tested(models.linear())
    assert [one.recording.name for one in judged] == ["log", "other", "test"]
    np.testing.assert_array_equal(masks[0], split.carried_uses[0] == VALIDATION)
    assert masks[0].any()
    assert masks[1:] == [None]
    assert set(judged[2].uses) == {TEST}


def test_models_are_alike_where_the_same_is_held(fits: Fits) -> None:
    models = selection()
    free, held = models.linear(), models.linear({"k": 1.0})
    more = models.extended(held, "backlash")
    assert models.alike(free) == [free]
    assert models.alike(more) == [held, more]


def test_a_trial_is_fitted_again_only_where_a_smaller_one_fits_better(
    fits: Fits, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = selection()
    trial = models.extended(models.linear(), "backlash")
    assert models.no_worse(trial) is trial
    lower = solution(trial.fit.problem, cost=0.01)
    monkeypatch.setattr(_models, "fitted_again", lambda trials, fit, budget: lower)
    assert models.no_worse(trial).fit is lower
