"""Limits that a fit never reaches, brought back."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import Solution, polish
from servosight.identify.fit._unreached import unreached, with_limits_reached
from servosight.identify.problem import Problem
from servosight.models.effects import catalogue

NOISE_DEG = 0.03
NAMES = ("dead_time", "torque_saturation", "coulomb_friction")
HIDDEN = {
    "torque_saturation__limit": 3.0,
    "coulomb_friction__level": 1.0,
    "dead_time__delay": 0.003,
}
FAR = {"T": 0.02, "xi": 1.2, "dead_time.delay": 0.02, "coulomb_friction.level": 1.0}


@pytest.fixture
def problem(record: Any) -> Problem:
    recordings = [record(6.0, noise_deg=NOISE_DEG, k=1.0, T=0.03, xi=0.6, **HIDDEN)]
    return Problem.of(recordings, catalogue(), NAMES, held={"k": 1.0})


def without_limit(problem: Problem) -> Solution:
    """Where a descent ends that begins with a long lag in the place of the limit."""
    start = np.zeros(len(problem.coordinates))
    for j, coordinate in enumerate(problem.coordinates):
        value = {"k": 1.0, "torque_saturation.limit": np.inf, **FAR}.get(coordinate.name, 0.0)
        start[j] = coordinate.to_search(value)
    return polish(problem, [np.clip(start, *problem.bounds)])


def test_a_limit_that_a_descent_has_lost_is_found_again(problem: Problem) -> None:
    """A lag longer than the servo's is a minimum of its own, at which the limit does nothing."""
    lost = without_limit(problem)
    assert lost.rmse_deg > 5.0 * NOISE_DEG
    assert [one.effect.id for one in unreached(lost)] == ["torque_saturation"]
    found = with_limits_reached(lost, 1.1 * NOISE_DEG)
    assert found.rmse_deg < 1.1 * NOISE_DEG
    values = problem.values(found.outcome.point)
    assert values["torque_saturation.limit"] == pytest.approx(3.0, rel=0.05)
    assert values["T"] == pytest.approx(0.03, rel=0.05)


def test_a_fit_that_errs_little_enough_is_left_as_it_is(problem: Problem) -> None:
    lost = without_limit(problem)
    before = problem.work.cost
    assert with_limits_reached(lost, 1.01 * lost.rmse_deg) is lost
    assert problem.work.cost == before


def test_a_limit_that_the_user_holds_is_not_moved(problem: Problem) -> None:
    held = replace(problem, held={"k": 1.0, "torque_saturation.limit": 50.0})
    lost = without_limit(held)
    assert unreached(lost) == []
    assert with_limits_reached(lost) is lost


def test_a_limit_that_acts_stays_where_it_is(problem: Problem) -> None:
    found = with_limits_reached(without_limit(problem), 1.1 * NOISE_DEG)
    assert unreached(found) == []
    assert with_limits_reached(found) is found


def test_a_speed_that_a_profile_s_descent_has_passed_is_found_again(record: Any) -> None:
    """A profile of 100 deg/s and 3,000 deg/s^2, begun at 1,000 deg/s: its acceleration acts, and of
    the speed alone nothing leads back."""
    hidden = {"motion_profile__rate": 100.0, "motion_profile__acceleration": 3000.0}
    recordings = [record(6.0, noise_deg=NOISE_DEG, k=1.0, T=0.03, xi=0.6, **hidden)]
    problem = Problem.of(recordings, catalogue(), ("motion_profile",), held={"k": 1.0})
    begun = {"k": 1.0, "T": 0.03, "xi": 0.6, "motion_profile.rate": 1e3}
    start = [
        c.to_search({"motion_profile.acceleration": 3e3, **begun}.get(c.name, 0.0))
        for c in problem.coordinates
    ]
    lost = polish(problem, [np.clip(start, *problem.bounds)])
    assert lost.rmse_deg > 5.0 * NOISE_DEG
    assert [(one.effect.id, one.names) for one in unreached(lost)] == [
        ("motion_profile", ("rate",))
    ]
    found = with_limits_reached(lost, 1.1 * NOISE_DEG)
    values = problem.values(found.outcome.point)
    assert values["motion_profile.rate"] == pytest.approx(100.0, rel=0.02)
    assert values["motion_profile.acceleration"] == pytest.approx(3000.0, rel=0.05)
