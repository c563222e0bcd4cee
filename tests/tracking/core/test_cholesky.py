"""Small normal equations: as NumPy solves them, and refused where they determine nothing."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.core import inverted, solved


@pytest.mark.parametrize("unknowns", [1, 3, 5])
def test_solutions_and_inverses_are_those_of_numpy(unknowns: int) -> None:
    rng = np.random.default_rng(unknowns)
    rows, side = rng.normal(size=(20, unknowns)), rng.normal(size=unknowns)
    matrix, step = rows.T @ rows, np.empty(unknowns)
    inverse = np.empty_like(matrix)
    assert solved(matrix, side, step)
    assert inverted(matrix, inverse)
    np.testing.assert_allclose(step, np.linalg.solve(matrix, side), rtol=1e-9)
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    "matrix", [np.ones((2, 2)), np.zeros((3, 3)), -np.eye(2), np.full((2, 2), np.nan)]
)
def test_what_is_not_positive_or_regular_is_refused(matrix: np.ndarray) -> None:
    assert not solved(matrix, np.ones(len(matrix)), np.empty(len(matrix)))
    assert not inverted(matrix, np.empty_like(matrix))
