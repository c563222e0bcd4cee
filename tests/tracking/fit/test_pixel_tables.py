"""The table of a picture's pixels, which is made in bands of rows."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.fit import Pixels, PolarGrid

SHAPE = (700, 90)


@pytest.mark.parametrize("every", [1, 7])
def test_bands_make_the_table_of_the_whole_picture(every: int) -> None:
    """Every so many of the pixels within reach, counted through all bands, by rising angle."""
    grid = PolarGrid((40.3, 310.8), 5.0, 1.0, -0.5, 0.01, 300, 100)
    y, x = np.indices(SHAPE)
    dx, dy = (x - grid.pivot_px[0]).ravel(), (grid.pivot_px[1] - y).ravel()
    near = np.flatnonzero(np.hypot(dx, dy) <= grid.largest_px)[::every]
    phi = np.mod(np.arctan2(dy, dx)[near], 2 * np.pi)
    order = np.argsort(phi, kind="stable")
    table = Pixels.about(grid, SHAPE, every)
    np.testing.assert_array_equal(table.index[: near.size], near[order])
    np.testing.assert_array_equal(table.phi_rad[: near.size], phi[order])
    np.testing.assert_allclose(table.radius_px[: near.size], np.hypot(dx, dy)[near[order]], 1e-6)
    assert table.index.size == 2 * near.size
