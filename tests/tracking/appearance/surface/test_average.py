"""The mean of frames turned back: the same for any number of threads, and of the cells wanted."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from servosight.models.core import Array, Single
from servosight.tracking.appearance.surface._average import average, spline_of, swept
from servosight.tracking.fit import PolarGrid

GRID = PolarGrid((60.0, 40.0), 4.0, 1.0, -0.8, 0.03, 30, 55)
ALL = np.ones((GRID.columns, GRID.rows), bool)


def frames() -> tuple[Single, Array, Array]:
    """Splines of pictures of noise, their angles and shifts."""
    rng = np.random.default_rng(4)
    splines = [spline_of(rng.integers(0, 255, (90, 120), np.uint8)) for _ in range(5)]
    return np.stack(splines), rng.uniform(-0.2, 0.2, 5), np.zeros((5, 2))


def test_the_average_does_not_depend_on_the_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit."""
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 1)
    alone = average(*frames(), GRID, ALL)
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 3)
    np.testing.assert_array_equal(alone, average(*frames(), GRID, ALL))


def test_cells_far_from_the_wanted_ones_do_not_change_the_spline_there() -> None:
    """The spline's filter forgets a cell at 10 cells' distance to 2e-6 of its grey level."""
    wanted = np.zeros_like(ALL)
    wanted[20:35, 10:20] = True
    apart = np.abs(average(*frames(), GRID, wanted) - average(*frames(), GRID, ALL))
    assert apart[wanted].max() < 0.01


@pytest.mark.parametrize("seed", range(4))
def test_no_cell_lies_outside_of_what_a_mask_sweeps(seed: int) -> None:
    """Of a mask of several pieces, at angles of up to a turn: with room of 40 px and no more."""
    rng = np.random.default_rng(seed)
    mask = rng.random((GRID.rows, GRID.columns)) < 0.03
    angles_rad = rng.uniform(-np.pi, np.pi, 4)
    rows, columns = swept(GRID, mask, angles_rad, (400, 500))
    row, column = np.nonzero(mask)
    radius = GRID.radius_px + GRID.step_px * row
    phi = GRID.phi_rad + GRID.step_rad * column + angles_rad[:, None]
    y, x = GRID.pivot_px[1] - radius * np.sin(phi), GRID.pivot_px[0] + radius * np.cos(phi)
    assert (rows.start, rows.stop) == (max(int(y.min()) - 40, 0), int(y.max()) + 40)
    assert (columns.start, columns.stop) == (max(int(x.min()) - 40, 0), int(x.max()) + 40)
