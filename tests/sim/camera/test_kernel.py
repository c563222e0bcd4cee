"""What is drawn reads nothing beside the layer that it draws."""

from __future__ import annotations

import numpy as np

from servosight.sim.camera._kernel import lay_along_rays


def test_a_ray_that_rounds_to_the_last_column_reads_none_beside_it() -> None:
    stored = np.full((4, 5, 2), np.nan, dtype=np.float32)
    stored[:3, :4] = 1.0
    edge = np.nextafter(3.0, 0.0)  # a column that single precision rounds to 3, the last one
    rays = np.array([[[edge, 1.0], [2.5, 1.0], [1.0, np.nextafter(2.0, 0.0)]]])
    picture = np.zeros((1, 3), dtype=np.float32)
    lay_along_rays(picture, stored[:3, :4], rays, np.eye(3))
    assert picture.tolist() == [[0.0, 1.0, 0.0]]
