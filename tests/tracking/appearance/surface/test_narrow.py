"""What is narrower than the margin along its edge has no pixel that is surely its own."""

from __future__ import annotations

import numpy as np

from servosight.tracking.appearance.surface import learn
from servosight.tracking.fit import PolarGrid

GRID = PolarGrid((60.0, 40.0), 4.0, 1.0, -0.8, 0.03, 60, 55)


def test_no_frame_shows_a_part_of_one_column() -> None:
    mask = np.zeros((GRID.rows, GRID.columns), bool)
    mask[20:50, 30] = True
    rng = np.random.default_rng(4)
    images = [rng.integers(0, 255, (90, 120), np.uint8) for _ in range(5)]
    surface, angle_rad = learn(images, np.linspace(-0.2, 0.2, 5), mask, GRID)
    assert surface.area_px(0.0) == 0.0
    assert np.isnan(angle_rad).all()
