"""The first look: what a change of the prediction would take off the error, to first order."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.diagnose.selection._screen import Screen

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
