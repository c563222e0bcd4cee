"""When a selection fits a model again: from a sketch, with more starts, to more samples."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.counted_fits import EFFECTS, Fits, recording, selection, solution

from servosight.diagnose.residuals import TEST, VALIDATION
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    SelectionPolicy,
    Split,
    Trial,
)
from servosight.diagnose.selection.trials import _models, _prediction
from servosight.identify.search import StopReason
from servosight.models.core import Array, Recording


def out_of_budget(trial: Trial) -> Trial:
    stopped = replace(trial.fit.outcome.stopped, reason=StopReason.BUDGET)
    return replace(
        trial, fit=replace(trial.fit, outcome=replace(trial.fit.outcome, stopped=stopped))
    )


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

    monkeypatch.setattr(_prediction, "carried_over", carried)
    split = Split.of([recording()], [recording(name="other")], [recording(name="test")])
    models = ModelSelection(split, EFFECTS)
    judged = models.tested(models.linear())
    assert [one.recording.name for one in judged] == ["log", "other", "test"]
    np.testing.assert_array_equal(masks[0], split.carried_uses[0] == VALIDATION)
    assert masks[0].any()
    assert masks[1:] == [None]
    assert set(judged[2].uses) == {TEST}


def test_a_trial_is_fitted_again_only_where_a_smaller_one_fits_better(
    fits: Fits, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = selection()
    trial = models.extended(models.linear(), "backlash")
    assert models.no_worse(trial) is trial
    lower = solution(trial.fit.problem, cost=0.01)
    monkeypatch.setattr(_models, "fitted_again", lambda trials, fit, budget: lower)
    assert models.no_worse(trial).fit is lower
