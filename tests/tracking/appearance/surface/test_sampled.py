"""A learnt surface at the pixels that it covers: beside scipy's spline, each pixel once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from servosight.tracking.appearance.surface import Surface
from servosight.tracking.fit import PolarGrid, Sample

SHAPE = (60, 70)
COLUMNS, ROWS = 150, 24


def surface(first: int, last: int) -> Surface:
    """A surface with cells in some of the columns of a raster that goes round once and a bit."""
    rng = np.random.default_rng(3)
    grid = PolarGrid((33.3, 28.7), 3.0, 1.0, -np.pi, 2 * np.pi / (COLUMNS - 4), ROWS, COLUMNS)
    reach = np.zeros((COLUMNS, ROWS), np.float32)
    reach[first:last, 2:-3] = 4.0
    reach[first + 20 : first + 30, 8:12] = 0.0  # a hole
    coefficients = rng.normal(100.0, 20.0, (COLUMNS, ROWS)).astype(np.float32)
    return Surface(grid, coefficients, reach, np.empty((0, 2)), 1.0, 1.0)


def sampled(part: Surface, angle_rad: float, stale: np.ndarray) -> Sample:
    return part.blurred(0.0).at(part.pixels(SHAPE), angle_rad, stale=stale)


def cells(part: Surface, angle_rad: float, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Column and row of pixels on the raster of a part at an angle."""
    y, x = np.divmod(index, SHAPE[1])
    dx, dy = x - part.grid.pivot_px[0], part.grid.pivot_px[1] - y
    turned = np.mod(np.arctan2(dy, dx) - angle_rad - part.grid.phi_rad, 2 * np.pi)
    return turned / part.grid.step_rad, np.hypot(dx, dy) - part.grid.radius_px


@pytest.mark.parametrize("cells_of", [(2, COLUMNS - 5), (30, 90)], ids=["wheel", "flap"])
@pytest.mark.parametrize("angle_rad", [0.0, -2.9, 1.3, 8.1])
def test_the_pixels_and_values_are_those_of_the_spline(
    cells_of: tuple[int, int], angle_rad: float
) -> None:
    part = surface(*cells_of)
    found = sampled(part, angle_rad, np.empty(0, bool))
    index = found.pixels.index[found.chosen]
    assert np.unique(index).size == index.size
    every = np.arange(SHAPE[0] * SHAPE[1])
    u, v = cells(part, angle_rad, every)
    near = np.rint(u).astype(int), np.clip(np.rint(v).astype(int), 0, ROWS - 1)
    inside = (u >= 1) & (u < COLUMNS - 2) & (v >= 1) & (v < ROWS - 2)
    clear = np.abs(np.abs(np.stack([u, v]) % 1.0) - 0.5).min(0) > 1e-3  # of rounding either way
    covered = inside & (part.reach[near[0] % COLUMNS, near[1]] > 0)
    np.testing.assert_array_equal(np.isin(every, index)[clear], covered[clear])
    places = np.stack(cells(part, angle_rad, index))
    value = ndimage.map_coordinates(part.coefficients, places, order=3, prefilter=False)
    np.testing.assert_allclose(found.value, value, atol=2e-3)


def test_stale_pixels_are_left_out_and_counted() -> None:
    part = surface(30, 90)
    whole = sampled(part, 0.4, np.empty(0, bool))
    stale = np.zeros(SHAPE, bool)
    stale[:, :40] = True
    new = sampled(part, 0.4, stale.ravel())
    index = new.pixels.index[new.chosen]
    assert (index % SHAPE[1]).min() == 40
    assert whole.left_out == 0
    assert 0 < new.left_out == whole.chosen.size - new.chosen.size
