"""A search that is not greedy: from a rich model down, from the best-ranked models up."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose.residuals import Judged
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    SearchEffort,
    Selected,
    SelectionPolicy,
    Split,
    Step,
    StepwiseSelector,
)
from servosight.diagnose.selection.search import (
    BackwardSearch,
    BeamSearch,
    Visited,
    simplified,
)
from servosight.identify.problem import Work
from servosight.models.core import Recording, degrees, silent
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus

HIDDEN = {
    "torque_saturation.limit": 8.0,
    "load_dependent_friction.ratio": 0.4,
    "gravity_load.sine": 6.0,
}
FLOOR_DEG = 0.03
KNOWN = ("dead_zone", "torque_saturation", "load_dependent_friction", "gravity_load")


def _recording(k: float = 1.0) -> Recording:
    """A geared servo that turns an arm: three effects at once."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    settings = {"k": k, "T": 0.03, "xi": 0.6, "bias": 0.0, "initial_angle": 0.0, **HIDDEN}
    for name, value in settings.items():
        row[plant.index(name)] = value
    drive = standard(6.0, 60.0, seed=3)
    time_s = 0.004 + np.arange(300) / 50.0
    stimulus = Stimulus(drive.time_s, drive.command_deg, False, time_s, np.ones(1))
    noise = np.random.default_rng(4).normal(0.0, FLOOR_DEG, time_s.size)
    angle = plant.simulate(row, stimulus, 1e-4) + noise
    return Recording("arm", drive.time_s, drive.command_deg, time_s, angle)


def _models(names: Collection[str], k: float = 1.0) -> ModelSelection:
    """A choice between these effects of the catalogue, whose kernel is compiled already."""
    known = PriorKnowledge(without_effects=tuple(name for name in catalogue() if name not in names))
    return ModelSelection(Split.of([_recording(k)]), catalogue(), known)


@pytest.fixture(scope="module")
def searched() -> tuple[StepwiseSelector, Selected, list[str]]:
    """The selection with steps left out from the start, and what it showed on the way."""
    models = _models(KNOWN)
    policy = SelectionPolicy(far=0.5, hopeless=0.0)
    shown: list[str] = []
    selector = StepwiseSelector(
        models,
        AcceptanceCriterion(FLOOR_DEG, 0.5 * FLOOR_DEG, policy),
        lambda stage, done, total=None: shown.append(stage),
        SearchEffort(fitted=2, leaders=1),
    )
    return selector, selector.select(), shown


@pytest.mark.parametrize(("k", "unloaded"), [(1.0, True), (-1.0, True), (0.8, False)])
def test_k_is_held_at_one_where_the_data_do_not_ask_for_another(k: float, unloaded: bool) -> None:
    models = _models(KNOWN[1:], k)
    policy = SelectionPolicy(ordinary=(*KNOWN[2:], "torque_saturation"))
    visited = Visited(models, AcceptanceCriterion(FLOOR_DEG, 0.5 * FLOOR_DEG, policy))
    assert BackwardSearch(models, visited, SearchEffort(), silent).search_unloaded() is unloaded
    if unloaded:
        best = visited.best()
        assert set(best.effects) == set(KNOWN[1:])
        assert best.fit.problem.values(best.fit.outcome.point)["k"] == k


def test_a_k_that_the_data_do_not_ask_for_is_held_in_the_answer() -> None:
    """The noise counts as unexplained here."""
    models = _models(KNOWN[1:])
    visited = Visited(models, AcceptanceCriterion(0.1 * FLOOR_DEG, 0.05 * FLOOR_DEG))
    linear = models.linear()
    steps = [Step(linear), Step(models.together(linear, KNOWN[1:]))]
    last = simplified(steps, visited, SearchEffort())[-1].trial
    assert set(last.effects) == set(KNOWN[1:])
    assert last.held == ("k",)


def test_the_linear_model_with_k_held_is_no_answer() -> None:
    """It may predict the validation data best, but no step leads to it."""
    models = _models(["gravity_load"])
    visited = Visited(models, AcceptanceCriterion(FLOOR_DEG, 0.5 * FLOOR_DEG))
    linear, held = models.linear(), models.unloaded()
    assert held is not None
    models.trials[held.key] = replace(held, judged=tuple(_without_error(x) for x in held.judged))
    assert visited.ranked()[0].held == ("k",)
    assert visited.best() is linear


def _without_error(judged: Judged) -> Judged:
    return replace(judged, predicted_deg=judged.recording.angle_deg)


@pytest.mark.parametrize("ordinary", [True, False])
def test_an_effect_is_exchanged_for_an_ordinary_one_that_contains_it(ordinary: bool) -> None:
    names = ("torque_saturation", "current_limit")
    models = _models(names)
    policy = SelectionPolicy(ordinary=names if ordinary else ())
    visited = Visited(models, AcceptanceCriterion(FLOOR_DEG, 0.5 * FLOOR_DEG, policy))
    models.extended(models.linear(), "torque_saturation")
    BeamSearch(models, visited, SearchEffort(fitted=0), silent).search()
    assert ((("current_limit",), ()) in models.trials) is ordinary


def first_deg(selected: Selected) -> float:
    return selected.steps[0].trial.score.validation_rmse_deg


def test_from_a_rich_model_down_to_what_is_there(
    searched: tuple[StepwiseSelector, Selected, list[str]],
) -> None:
    selector, selected, shown = searched
    last = selected.steps[-1].trial
    assert {name.split(".")[0] for name in HIDDEN} == set(last.effects)
    values = last.fit.problem.values(last.fit.outcome.point)
    for name, true in HIDDEN.items():
        assert values[name] == pytest.approx(true, rel=0.1)
    assert selector.criterion.done(last.score)
    assert last.key[1] == ("k",)  # held at 1, where it is
    assert values["k"] == 1.0
    assert last.score.parameters == len(values) - 1
    assert any(stage.startswith("rich model") for stage in shown)
    best = [stage for stage in shown if stage.startswith("best so far: ")]
    assert best[0].startswith(f"best so far: the linear model, {degrees(first_deg(selected))} rms")
    assert best[-1].startswith("best so far: torque saturation + ")


def test_a_search_that_has_used_up_its_simulations_gives_the_best_so_far(
    searched: tuple[StepwiseSelector, Selected, list[str]],
) -> None:
    whole, selected, _ = searched
    models = replace(whole.models, trials={}, wholes={}, screens={}, work=Work())
    short = StepwiseSelector(models, whole.criterion, effort=replace(whole.effort, cost=1.0))
    cut = short.select()
    assert cut.cut_short
    assert not selected.cut_short
    assert models.work.simulations < whole.models.work.simulations
    first, *_, last = [cut.steps[0], *cut.steps]
    penalised_error = short.criterion.penalised_error
    assert penalised_error(last.trial.score) <= penalised_error(first.trial.score)


def test_the_path_adds_one_effect_a_step(
    searched: tuple[StepwiseSelector, Selected, list[str]],
) -> None:
    selector, selected, _ = searched
    assert selected.steps[0].trial.effects == ()
    assert selected.steps[0].trial is selector.models.first()  # its best fit, whenever found
    for before, after in zip(selected.steps, selected.steps[1:], strict=False):
        assert after.removed is None
        assert set(after.trial.effects) == {*before.trial.effects, after.added}


def test_no_model_that_was_seen_is_better_than_the_answer(
    searched: tuple[StepwiseSelector, Selected, list[str]],
) -> None:
    selector, selected, _ = searched
    penalised_error = selector.criterion.penalised_error
    last = selected.steps[-1].trial
    for one in selector.models.trials.values():
        frees = one.effects == last.effects and one.key != last.key  # k need not be fitted
        assert frees or penalised_error(last.score) <= penalised_error(one.score) + 5e-4
