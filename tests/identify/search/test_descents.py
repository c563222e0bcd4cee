"""Damped descents on problems whose answer is known, and on any that are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.valleys import LOW, descent, rosenbrock

from servosight.identify.search import (
    ESTIMATORS,
    LevenbergMarquardt,
    SearchSpace,
    StopReason,
    drive,
    half_squares,
)
from servosight.models.core import Array


def test_descents_follows_a_bent_valley_to_the_minimum() -> None:
    """Rosenbrock's own start; 300 evaluations are 33 generations of 9, half of what is allowed."""
    outcome = drive(descent(np.array([-1.2, 1.0])), rosenbrock, 300)
    np.testing.assert_allclose(outcome.point, [1.0, 1.0], atol=1e-6)
    assert outcome.stopped.reason is StopReason.CONVERGED


def test_descents_stops_at_a_bound_that_cuts_the_minimum_off() -> None:
    """With x <= 0.5 the minimum is (0.5, 0.25), at a cost of 0.5^2 / 2."""
    estimator = LevenbergMarquardt(np.zeros(2), LOW, np.array([0.5, 2.0]), np.ones(2))
    outcome = drive(estimator, rosenbrock, 2_000)
    np.testing.assert_allclose(outcome.point, [0.5, 0.25], atol=1e-4)
    assert outcome.cost == pytest.approx(0.125, rel=1e-4)


def test_descents_goes_on_from_where_it_stood() -> None:
    first = descent(np.array([-1.2, 1.0]))
    part = drive(first, rosenbrock, 30)
    whole = drive(first.resumed(), rosenbrock, 2_000)
    assert whole.cost < part.cost
    np.testing.assert_allclose(whole.point, [1.0, 1.0], atol=1e-4)


finite = st.floats(-3.0, 3.0, allow_nan=False)


@settings(max_examples=60)
@given(
    slopes=st.lists(st.tuples(finite, finite, finite), min_size=3, max_size=6),
    bend=st.floats(-1.0, 1.0),
    start=st.tuples(finite, finite),
    low=st.tuples(st.floats(-3.0, -0.1), st.floats(-3.0, -0.1)),
    width=st.tuples(st.floats(0.01, 5.0), st.floats(0.01, 5.0)),
)
def test_descents_keeps_bounds_and_never_climbs(
    slopes: list[tuple[float, float, float]],
    bend: float,
    start: tuple[float, float],
    low: tuple[float, float],
    width: tuple[float, float],
) -> None:
    """On any bent least-squares problem, from any start, also one outside the bounds."""
    table = np.array(slopes)
    lower = np.array(low)
    upper = lower + np.array(width)

    def residuals(points: Array) -> Array:
        assert np.all(points >= lower)
        assert np.all(points <= upper)
        return points @ table[:, :2].T - table[:, 2] + bend * points[:, :1] ** 2

    first = np.clip(np.array(start), lower, upper)
    outcome = drive(LevenbergMarquardt(np.array(start), lower, upper, np.ones(2)), residuals, 3_000)
    assert np.all(np.diff(outcome.history) <= 0.0)
    assert outcome.cost <= half_squares(residuals(first[None, :]))[0] * (1 + 1e-12)
    assert str(outcome.stopped)


def test_a_descent_goes_on_where_a_quotient_exceeds_all_numbers() -> None:
    """Residuals may change by more than a number holds, where simulations fail."""
    space = SearchSpace(np.full(2, -5.0), np.full(2, 5.0), np.ones(2), guesses=np.ones((1, 2)))

    def residuals(points: Array) -> Array:
        return np.stack([points[:, 0] - 2.0, 1e160 * (points[:, 1] - 1.0)], axis=1)

    with np.errstate(over="ignore", invalid="ignore"):
        outcome = drive(ESTIMATORS["gradient"](space), residuals, budget=60)
    assert np.all(np.isfinite(outcome.point))
