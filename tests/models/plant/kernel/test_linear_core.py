"""The core's update over a step, against the matrix exponential and against two half steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from servosight.models.plant.kernel._linear_core import core_update, doubled


@pytest.mark.parametrize("xi", [0.02, 0.55, 1.0, 3.0])
@pytest.mark.parametrize("share", [0.01, 0.1, 0.2, 0.5, 2.0])
def test_an_update_is_the_exponentials_and_twice_its_half(share: float, xi: float) -> None:
    """N = 1, s/h, (s/h)^2 as states of their own; answers in units of T, good to rounding.

    Where the closed forms take over, they cancel by up to (T / h)^4.
    """
    T = 0.0078
    h = share * T
    system = np.zeros((5, 5))
    system[:2, :2] = [[0.0, 1.0], [-1.0 / T**2, -2.0 * xi / T]]
    system[1, 2] = 1.0  # N, N' and N'' follow
    system[2, 3] = system[3, 4] = 1.0
    answer = expm(h * system)
    exact = [
        *answer[:2, :2].ravel(),
        *answer[:2, 2],
        *(answer[:2, 3] / h),
        *(2 * answer[:2, 4] / h**2),
    ]
    units = np.array([1.0, T, 1.0 / T, 1.0, T * T, T, T * T, T, T * T, T])
    np.testing.assert_allclose(core_update(T, xi, h) / units, exact / units, rtol=0.0, atol=1e-11)
    twice = doubled(core_update(T, xi, 0.5 * h))
    np.testing.assert_allclose(twice / units, exact / units, rtol=0.0, atol=1e-11)
