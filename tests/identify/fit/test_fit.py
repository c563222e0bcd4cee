"""Fits behind fits: more freedom never costs more, and recordings share what they share."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import Solution, _solution, fit_effects, polish
from servosight.identify.problem import (
    BaseModel,
    Problem,
    effect_guesses,
    effect_starts,
    neutral_start,
)
from servosight.models.effects import catalogue


@pytest.mark.parametrize("more", ["stribeck_friction", "backlash", "speed_limit", "cogging"])
def test_an_effect_more_never_costs_more(more: str, record: Any) -> None:
    recordings = [record(4.0, coulomb_friction__level=1.0)]
    base = fit_effects(Problem.of(recordings, catalogue(), ["coulomb_friction"]))
    effects = [name for name in catalogue() if name in ("coulomb_friction", more)]
    both = fit_effects(Problem.of(recordings, catalogue(), effects), base)
    assert both.outcome.cost <= base.outcome.cost


@pytest.mark.parametrize("xi", [0.4, 8.0])
def test_starts_have_the_lag_that_they_stand_for_and_an_overdamped_core_does_not_stay_so(
    xi: float, record: Any
) -> None:
    recordings = [record(2.0)]
    point = np.array([1.0, np.log(0.01), np.log(xi), 0.5, 0.5, 0.0])
    base = BaseModel(Problem.of(recordings, catalogue(), ()), point)
    problem = Problem.of(recordings, catalogue(), ["coulomb_friction"])
    guesses, starts = effect_guesses(problem, base), effect_starts(problem, base)
    T, damping = np.exp(np.array(starts)[:, 1:3].T)
    shares = np.tile([1.0, 0.5, 0.2], len(guesses))
    np.testing.assert_allclose(T * damping, shares * 0.01 * xi)
    np.testing.assert_allclose(damping, np.where(shares == 1.0, xi, min(xi, 1.0)))
    np.testing.assert_array_equal(starts[::3], guesses)


def test_joint_predictions_are_those_of_each_recording(record: Any) -> None:
    recordings = [record(2.0), record(3.0, seed=1, k=0.9)]
    joint = Problem.of(recordings, catalogue(), ["backlash"])
    rng = np.random.default_rng(3)
    points = np.tile(rng.uniform(0.1, 0.5, len(joint.coordinates)), (5, 1))
    points[1:, -4:] += rng.uniform(size=(4, 4))  # the second recording's own, and one of the first
    for r, recording in enumerate(recordings):
        alone = Problem.of([recording], catalogue(), ["backlash"])
        mine = np.hstack([points[:, : joint.physical], points[:, joint.physical + 3 * r :][:, :3]])
        np.testing.assert_array_equal(joint.predict(points)[r], alone.predict(mine)[0])


def test_a_descent_comes_to_an_end_where_rounding_always_promises_less(
    record: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A limit of next to nothing and none at all cost the same but for rounding."""
    problem = Problem.of([record(2.0)], catalogue(), ["torque_saturation"])
    linear = fit_effects(Problem.of(problem.recordings, catalogue(), []))
    start = neutral_start(problem, linear.as_base)
    offered = []

    def same(found: Solution) -> Solution:
        offered.append(found)
        return found

    monkeypatch.setattr(_solution, "_better", same)
    found = polish(problem, [start])
    assert found.outcome.cost <= linear.outcome.cost * (1.0 + 1e-9)
    assert len(offered) <= len(problem.coordinates)
