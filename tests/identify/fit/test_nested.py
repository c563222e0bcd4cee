"""A fit that ends worse than a model which it contains is repeated from that one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import Solution, contains, fit_effects, no_worse, polish
from servosight.identify.problem import BaseModel, Problem, linear_start, neutral_start
from servosight.identify.search import half_squares
from servosight.models.effects import catalogue


@pytest.fixture
def smaller(record: Any) -> Solution:
    recordings = [record(4.0, coulomb_friction__level=1.0)]
    return fit_effects(Problem.of(recordings, catalogue(), ["coulomb_friction"]))


def poor(smaller: Solution) -> Solution:
    """A fit with one effect more that ended far off, as in a local minimum."""
    old = smaller.problem
    problem = Problem(old.recordings, old.plant, ("coulomb_friction", "backlash"), old.masks)
    point = neutral_start(problem, smaller.as_base)
    point[0] *= 0.8
    cost = float(half_squares(problem.residuals(point[None, :]))[0])
    return Solution(problem, replace(smaller.outcome, point=point, cost=cost))


def test_it_is_done_again_and_says_so(smaller: Solution) -> None:
    fit = poor(smaller)
    assert contains(fit, smaller)
    assert fit.outcome.cost > smaller.outcome.cost
    again = no_worse(fit, smaller)
    assert again.outcome.cost <= smaller.outcome.cost
    (note,) = again.notes
    assert f"{fit.rmse_deg:.4g} deg, worse than the {smaller.rmse_deg:.4g} deg" in note
    assert "coulomb_friction, which it contains" in note


def test_a_fit_that_is_better_stays_as_it_is(smaller: Solution) -> None:
    good = no_worse(poor(smaller), smaller)
    assert no_worse(good, smaller) is good


def test_only_a_model_with_fewer_of_the_same_effects_on_the_same_samples_is_contained(
    smaller: Solution,
) -> None:
    fit, old = poor(smaller), smaller.problem
    linear = Problem(old.recordings, old.plant, (), old.masks)
    assert contains(fit, polish(linear, [linear_start(linear)]))
    held = replace(smaller, problem=replace(old, held={"k": 1.0}))
    assert contains(fit, held)  # it may have that k, too
    pinned = replace(fit, problem=replace(fit.problem, held={"k": 1.0}))
    assert contains(pinned, held)
    assert not contains(pinned, smaller)  # which may have another
    fewer = tuple(np.arange(mask.size) % 2 == 0 for mask in old.masks)
    elsewhere = replace(smaller, problem=replace(old, masks=fewer))
    other = replace(smaller, problem=replace(old, effects=("dead_zone",)))
    for apart in (elsewhere, other, fit):
        assert not contains(fit, apart)
        with pytest.raises(ValueError, match="fewer of the same effects"):
            no_worse(fit, apart)


def test_an_effect_without_guesses_starts_at_neutral(record: Any) -> None:
    """The terms of a law come with none."""
    known = catalogue()
    unguessed = replace(known["backlash"], starts=lambda features: ())
    linear = fit_effects(Problem.of([record(2.0)], known, []))
    problem = Problem.of([record(2.0)], {**known, "backlash": unguessed}, ["backlash"])
    start = neutral_start(problem, BaseModel(linear.problem, linear.outcome.point))
    assert start == pytest.approx(np.insert(linear.outcome.point, 3, 0.0))
