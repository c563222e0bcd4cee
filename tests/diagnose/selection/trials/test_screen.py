"""The first look: what a change of the prediction would take off the error, to first order."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import nnls

from servosight.diagnose.selection.trials._screen import Screen

SAMPLES = 400


@pytest.fixture
def made() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Six changes, a residual made of the third and the fifth, and a Jacobian of four columns."""
    rng = np.random.default_rng(3)
    jacobian = rng.normal(size=(SAMPLES, 4))
    changes = rng.normal(size=(6, SAMPLES))
    noise = 0.1 * rng.normal(size=SAMPLES)
    residual = jacobian @ [1.0, -2.0, 0.5, 3.0] - 2.0 * changes[2] - 0.7 * changes[4] + noise
    return changes, residual, jacobian


def left_over(columns: NDArray[np.float64], residual: NDArray[np.float64]) -> float:
    answer = np.linalg.lstsq(columns, residual, rcond=None)[0]
    return float(np.sum((residual - columns @ answer) ** 2))


def test_a_gain_is_what_least_squares_takes_off(
    made: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> None:
    changes, residual, jacobian = made
    screen = Screen.of(tuple("abcdef"), changes, residual, jacobian)
    alone = left_over(jacobian, residual)
    for i in (2, 4):
        both = left_over(np.column_stack([jacobian, changes[i]]), residual)
        assert screen.gains[i] == pytest.approx(alone - both, rel=1e-9)
    pair = left_over(np.column_stack([jacobian, changes[2], changes[4]]), residual)
    assert screen.pair_gains[2, 4] == pytest.approx(alone - pair, rel=1e-9)
    assert screen.best(2) == ["c", "e"]
    assert screen.best_pairs(1, "abcdef") in ([("c", "e")], [("e", "c")])


def test_two_changes_gain_what_non_negative_least_squares_takes_off() -> None:
    """For every pair, also where one of the two would help only the other way round or is the same.

    Truth: scipy's solution (Lawson and Hanson 1974).
    """
    rng = np.random.default_rng(11)
    jacobian, residual = rng.normal(size=(8, 1)), rng.normal(size=8)
    changes = rng.normal(size=(12, 8))
    changes[5] = 3.0 * changes[4]
    changes[6] = -changes[4]
    changes[7] = changes[8] + 0.02 * changes[7]
    screen = Screen.of(tuple("abcdefghijkl"), changes, residual, jacobian)
    basis = jacobian[:, 0] / np.linalg.norm(jacobian)
    left = residual - basis * (basis @ residual)
    own = changes - np.outer(changes @ basis, basis)
    for i in range(12):
        for j in range(12):
            _, error = nnls(-own[[i, j]].T, left)
            assert screen.pair_gains[i, j] == pytest.approx(left @ left - error**2, abs=1e-7)


def test_pairs_are_of_different_effects_among_those_asked_for() -> None:
    gains = np.array([[9.0, 8.0, 5.0, 0.0], [8.0, 9.0, 7.0, 6.0], [5.0, 7.0, 9.0, 0.0], [0.0] * 4])
    screen = Screen(("a", "a", "b", "c"), np.array([1.0, 2.0, 3.0, 0.0]), gains)
    assert screen.best(2) == ["b", "a"]
    assert screen.best_pairs(9, "abc") == [("a", "b"), ("a", "c"), ("b", "c")]
    assert screen.best_pairs(1, "abc") == [("a", "b")]
    assert screen.best_pairs(9, "ac") == [("a", "c")]
    assert screen.best_pairs(0, "abc") == []


def test_a_change_the_wrong_way_gains_nothing(
    made: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> None:
    """An effect acts one way only: friction does not push."""
    changes, residual, jacobian = made
    screen = Screen.of(tuple("abcdef"), -changes, residual, jacobian)
    assert screen.gains[2] == 0.0
    assert screen.gains[4] == 0.0


def test_what_the_model_can_do_for_itself_is_no_gain() -> None:
    rng = np.random.default_rng(4)
    jacobian = rng.normal(size=(SAMPLES, 3))
    residual = rng.normal(size=SAMPLES)
    idle = np.zeros(SAMPLES)
    changes = np.stack([jacobian @ [1.0, 1.0, 0.0], idle, -residual])
    screen = Screen.of(("same", "idle", "right"), changes, residual, jacobian)
    assert screen.gains[:2] == pytest.approx([0.0, 0.0], abs=1e-9 * SAMPLES)
    assert screen.best(1) == ["right"]
    assert np.all(np.isfinite(screen.pair_gains))


def test_starts_of_one_effect_are_no_pair() -> None:
    rng = np.random.default_rng(5)
    changes = rng.normal(size=(3, SAMPLES))
    screen = Screen.of(("a", "a", "b"), changes, -changes.sum(axis=0), np.ones((SAMPLES, 1)))
    (pair,) = screen.best_pairs(9, "ab")
    assert set(pair) == {"a", "b"}
    assert screen.best_pairs(9, "a") == []


def test_an_effect_that_promises_less_than_is_asked_of_it_is_left_out() -> None:
    """By the best of its changes; the others stay as they are."""
    gains = np.arange(16.0).reshape(4, 4)
    screen = Screen(("a", "a", "b", "c"), np.array([1.0, 3.0, 2.0, 0.0]), gains)
    assert screen.promising({"a": 3.0, "b": 0.0}).names == ("a", "a", "b", "c")
    left = screen.promising({"a": 3.1})
    assert left.names == ("b", "c")
    assert left.gains.tolist() == [2.0, 0.0]
    assert left.pair_gains.tolist() == [[10.0, 11.0], [14.0, 15.0]]
