"""Costs with many minima: a prediction that jumps with its parameters, and many starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import servosight as ss
from servosight.identify.fit import Solution, _solution, fit_effects, polish
from servosight.identify.problem import Problem, linear_start
from servosight.models.effects import catalogue


def test_both_limits_of_a_profile_are_found() -> None:
    """Truth: the MuJoCo twin. Bounds: four sigma, and the noise of 0.03 deg plus 6 %.

    The rms of 2400 samples scatters by 1.5 %. In a neighbouring minimum it is 0.1 deg and more.
    """
    truth = {"motion_profile.rate": 120.0, "motion_profile.acceleration": 12000.0}
    recording = ss.simulate(effect="motion_profile", set=truth, seed=2)

    fit = ss.identify(recording, effects=["motion_profile"])

    assert fit.rmse_deg < 1.06 * 0.03
    for name, value in truth.items():
        found = fit.parameters[name]
        assert found.sigma is not None
        assert abs(found.value - value) < 4.0 * found.sigma
        assert found.sigma < 0.002 * value


@pytest.mark.parametrize("effect", ["coulomb_friction", "motion_profile"])
def test_of_many_starts_only_the_leading_ones_are_followed(effect: str) -> None:
    """The same minimum from one good start among twelve, for less than following four of them.

    Bounds: the stop of a descent, a gain of 1e-5 of the cost, of which several can be left; four
    whole descents of at most 30 generations each, with as many points as it has coordinates and 7.
    """
    recording = ss.simulate(effect=effect, seed=2)
    problem = Problem.of([recording], catalogue(), [effect])
    base = polish(problem.linear, [linear_start(problem.linear)])
    known = fit_effects(problem, base)
    far = known.outcome.point + np.linspace(1.0, 3.0, 11)[:, None]
    starts = [*np.clip(far, *problem.bounds), known.outcome.point]
    before = problem.work.simulations
    fit = polish(problem, starts)
    assert fit.outcome.cost <= 1.001 * known.outcome.cost
    descent = 30 * (len(problem.coordinates) + 7)
    assert problem.work.simulations - before < 4 * descent


def test_a_fit_that_goes_on_gaining_ends_with_its_simulations(
    record: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It begins again as long as that gains, each time with 2,000 of the 4,000 that it may have."""
    problem = Problem.of([record(2.0)], catalogue(), ())
    begun = []

    def better(fit: Solution) -> Solution:
        begun.append(fit)
        problem.work.simulations += 2_000
        return fit

    monkeypatch.setattr(_solution, "_better", better)
    polish(problem, [linear_start(problem)])
    assert len(begun) == 2
