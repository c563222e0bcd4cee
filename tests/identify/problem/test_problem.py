"""What simulations cost, counted and not timed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.problem import Problem, Work, linear_start, noise_deg
from servosight.models.effects import catalogue


def cost(problem: Problem, **values: float) -> float:
    """What one simulation costs with these parameters, the others from a linear start."""
    point = linear_start(problem.linear)
    names = [one.name for one in problem.linear.coordinates]
    known = {**dict(zip(names, point, strict=True)), **values}
    asked = np.array([known[one.name] for one in problem.coordinates])
    before = problem.work.cost
    problem.residuals(asked[None, :])
    return problem.work.cost - before


def test_a_simulation_costs_as_many_steps_as_it_takes(record: Any) -> None:
    """A faster motor under a load takes shorter steps; the length of the recording is no cost."""
    recording = record(3.0)
    problem = Problem.of([recording], catalogue(), ["gravity_load"], work=Work())
    load = {"gravity_load.sine": 2.0, "gravity_load.cosine": 0.0}
    slow = cost(problem, T=np.log(0.02), **load)
    fast = cost(problem, T=np.log(0.005), **load)
    assert fast > 1.9 * slow > 0.0
    short = recording.time_s < 0.5 * recording.time_s[-1]
    half = replace(
        recording,
        time_s=recording.time_s[short],
        angle_deg=recording.angle_deg[short],
        sigma_deg=None,
    )
    shorter = replace(problem, recordings=(half,), masks=(np.ones(int(short.sum()), bool),))
    assert cost(shorter, T=np.log(0.02), **load) == pytest.approx(slow, rel=0.25)


def test_equal_rows_are_simulated_once(record: Any) -> None:
    """As where a held parameter is varied for a difference quotient."""
    problem = Problem.of([record(3.0)], catalogue(), [], work=Work())
    point = linear_start(problem)
    other = point + np.eye(point.size)[0]
    before = problem.work.simulations
    answers = problem.residuals(np.array([other, point, other]))
    assert problem.work.simulations == before + 2
    np.testing.assert_array_equal(answers[0], answers[2])
    np.testing.assert_array_equal(answers[1], problem.residuals(point[None, :])[0])


def test_a_noise_that_is_known_is_not_estimated_again(record: Any) -> None:
    """Where the samples have sigmas of their own, these hold."""
    measured = record(3.0)
    plain = replace(measured, sigma_deg=None)
    own = replace(measured, sigma_deg=np.full(measured.time_s.size, 0.2))
    given = Problem.of([plain, own], catalogue(), [], noises_deg=(0.5, 0.5)).sample_noises_deg
    assert [set(one) for one in given] == [{0.5}, {0.2}]
    estimated = Problem.of([plain], catalogue(), []).sample_noises_deg
    assert set(estimated[0]) == {noise_deg(plain)}
