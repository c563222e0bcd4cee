"""A selection that comes by the same model again takes what it found there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from servosight.diagnose.selection import Split
from servosight.diagnose.selection.trials import ModelSelection
from servosight.diagnose.selection.trials._kept import best_kept
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
