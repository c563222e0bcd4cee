"""A selection that comes by the same model again takes what it found there."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from servosight.diagnose.selection import Score, Split
from servosight.diagnose.selection.trials import ModelSelection
from servosight.diagnose.selection.trials._kept import best_kept, reached_deg
from servosight.identify.problem import Work
from servosight.models.effects import catalogue


def models_of(twin: Any) -> ModelSelection:
    recording, _ = twin("backlash", duration_s=6.0)
    return ModelSelection(Split.of([recording], [], []), catalogue(), work=Work())


def test_the_same_way_from_the_same_model_is_simulated_once(twin: Any) -> None:
    models = models_of(twin)
    linear = models.linear()
    sketch = models.sketched(linear, "backlash")
    found = models.extended(linear, "backlash", sketch)
    spent = models.work.simulations
    again = models.extended(linear, "backlash", models.sketched(linear, "backlash"))
    assert again is found
    # What was fitted is judged again, by one simulation each for the sketch and the fit.
    assert models.work.simulations - spent <= 2


def test_a_fit_that_ends_where_the_best_did_is_that_one(twin: Any) -> None:
    """Later steps then find what was tried behind the first; a fit to its end goes first."""
    linear = models_of(twin).linear()
    trials = {linear.key: linear}
    cost = linear.fit.outcome.cost
    for factor, kept in ((1.0 + 1e-9, True), (1.0 - 1e-9, True), (1.1, False), (0.9, False)):
        outcome = replace(linear.fit.outcome, cost=factor * cost)
        other = replace(linear, fit=replace(linear.fit, outcome=outcome))
        assert (best_kept(dict(trials), other) is linear) is kept


@pytest.mark.parametrize(
    ("changes", "reached"),
    [
        ({}, 0.3),
        ({"validation_rmse_deg": 0.4}, 0.4),
        ({"at_bounds": ("backlash",)}, math.inf),
        ({"effects": ("backlash", "dead_time")}, math.inf),
    ],
)
def test_what_models_with_fewer_effects_reach(changes: dict[str, Any], reached: float) -> None:
    """The larger of two errors, of models with none of their effects at a bound."""
    score = Score(
        effects=("backlash",), parameters=4, samples=600, mean_square_deg2=0.09,
        train_rmse_deg=0.3, validation_rmse_deg=0.2, validation_samples=100, gain_fitted=True,
    )  # fmt: skip
    score = replace(score, **changes)
    trials: Any = {1: SimpleNamespace(effects=score.effects, score=score)}
    assert reached_deg(trials, ("gravity_load", "dead_time")) == reached
