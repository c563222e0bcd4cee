"""A drawn disc of smooth grain, turned by known angles: found by the wide search, then fitted."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Image
from servosight.tracking.appearance.surface import Surface, search, single
from servosight.tracking.fit import AngleFit, PolarGrid, gauss_newton, judged_fit

PIVOT_PX = (100.0, 90.0)
REACH_PX = 70.0
SHAPE = (180, 200)


def turned(angle_deg: float, gain: float = 1.0, offset: float = 0.0) -> Image:
    """Grain with a detail of some 5 px and noise of 2 grey levels, turned about the pivot."""
    rng = np.random.default_rng(1)
    grain = cv2.GaussianBlur(rng.standard_normal(SHAPE), (0, 0), 2.5)
    matrix = cv2.getRotationMatrix2D(PIVOT_PX, angle_deg, 1.0)
    seen = cv2.warpAffine(grain, matrix, SHAPE[::-1], flags=cv2.INTER_CUBIC)
    noise = 2.0 * np.random.default_rng(2).standard_normal(SHAPE)
    grey = gain * (120.0 + 30.0 * seen / grain.std()) + offset + noise
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def surface() -> Surface:
    columns = 300
    grid = PolarGrid(PIVOT_PX, 4.0, 1.5, -np.pi, 2 * np.pi / columns, columns=columns, rows=44)
    return single(turned(0.0), np.ones((grid.rows, grid.columns), bool), grid)


@pytest.mark.parametrize("angle_deg", [-170.0, -3.3, 0.0, 95.0])
def test_the_search_needs_no_start(surface: Surface, angle_deg: float) -> None:
    """Within its stride of 1.6 px at the rim."""
    picture = turned(angle_deg, gain=0.7, offset=30.0)
    found_rad, score = search(surface, surface.few_pixels(SHAPE), picture, 0.0, np.pi)
    assert np.rad2deg(found_rad) == pytest.approx(angle_deg, abs=np.rad2deg(1.6 / REACH_PX))
    assert score > 0.8


@pytest.mark.parametrize("start_deg", [-1.5, 1.5])
def test_a_fit_ends_at_the_same_angle_from_a_start_far_off(
    surface: Surface, start_deg: float
) -> None:
    """In other light, from 1.8 px off at the rim as from the truth: to a third of sigma."""
    picture = turned(20.0, gain=0.6, offset=40.0)
    rounds = surface.blurred(0.0).rounds(surface.pixels(SHAPE))

    def fitted(angle_deg: float) -> AngleFit:
        ended = gauss_newton(rounds, picture, np.deg2rad(angle_deg), least=1)
        assert ended is not None
        return judged_fit(ended)

    near, far = fitted(20.0), fitted(20.0 + start_deg)
    assert abs(far.angle_rad - near.angle_rad) < near.sigma_rad / 3.0
