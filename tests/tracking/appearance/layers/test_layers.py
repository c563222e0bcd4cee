"""What the learnt layers say of their place in the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.tracking.appearance.layers._layers import Layers
from servosight.tracking.fit import PolarGrid

SHAPE = (100, 120)


def layers(bench: float) -> Layers:
    """A bar of 6 degrees, from the middle of the picture to the right."""
    grid = PolarGrid((60.0, 50.0), 10.0, 1.0, -0.05, 0.005, 40, 21)
    used = np.full((grid.rows, grid.columns), 2, np.uint8)
    coefficients = np.zeros((grid.rows, grid.columns, 2), np.float32)
    return Layers(grid, coefficients, used, np.full(SHAPE, bench, np.float32), 1.0, 0.0, 1.0)


@pytest.mark.parametrize("bench", [90.0, np.nan], ids=["known", "unknown"])
def test_in_view_is_by_place_alone(bench: float) -> None:
    """Radii 10 to 49: all of it to the right (x < 110), all of it upwards (y >= 1)."""
    assert layers(bench).in_view(0.0) == 1.0
    assert layers(bench).in_view(np.pi / 2) == 1.0


def test_a_part_beyond_the_edge_is_cut() -> None:
    """The pivot 20 px lower: of radii r, weighed by r, those below 29.5 px are seen."""
    whole = layers(90.0)
    radius = np.arange(10.0, 50.0)
    below = replace(whole, grid=replace(whole.grid, pivot_px=(60.0, 70.0)))
    share = radius[radius < 29.5].sum() / radius.sum()
    assert below.in_view(-np.pi / 2) == pytest.approx(share, abs=0.01)
