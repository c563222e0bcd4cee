"""What a fit within bounds determines."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.identify.uncertainty import determined_inverse, inverse_within

FREE = np.array([0.5, 0.5, 0.5])


def _columns(correlation: float) -> np.ndarray:
    """Three columns, the first two with that correlation."""
    one, other, third = np.linalg.qr(np.random.default_rng(5).normal(size=(40, 3)))[0].T
    along = correlation * one + np.sqrt(1.0 - correlation**2) * other
    return np.stack([one, along, third], axis=1)


def _found(jacobian: np.ndarray, point: np.ndarray, own: list[bool], variance: float) -> np.ndarray:
    bounds = np.zeros(3), np.ones(3)
    return inverse_within(jacobian, point, bounds, np.array(own), variance)


def test_a_coordinate_on_a_bound_leaves_what_stands_in_for_it_uncertain() -> None:
    """With columns that correlate by 0.9 the variance is 1 / (1 - 0.81), as inside the bounds."""
    jacobian = _columns(0.9)
    inside = _found(jacobian, FREE, [False] * 3, 1e-3)
    resting = _found(jacobian, np.array([0.5, 0.0, 0.5]), [False] * 3, 1e-3)
    np.testing.assert_allclose(resting, inside)
    assert resting[0, 0] == pytest.approx(1.0 / 0.19)


@pytest.mark.parametrize(
    ("correlation", "own", "variance"),
    [(0.9, True, 1e-3), (0.9, False, 1.0), (1.0, False, 1e-3)],
    ids=["a recording's own", "uncertain beyond its range", "no different from another"],
)
def test_a_bound_is_taken_as_known(correlation: float, own: bool, variance: float) -> None:
    """Where freeing it tells nothing of the others, their variance is that without it."""
    jacobian = _columns(correlation)
    found = _found(jacobian, np.array([0.5, 0.0, 0.5]), [False, own, False], variance)
    alone = determined_inverse(jacobian, np.array([True, False, True]))
    np.testing.assert_allclose(found, alone)
    assert found[0, 0] == pytest.approx(1.0)
