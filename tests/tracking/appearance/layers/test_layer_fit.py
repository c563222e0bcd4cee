"""Layers learnt about a pivot that is off: the frames that they were not learnt from tell by how
much, and a bench as richly printed as the surface does not keep them from settling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erf

from servosight.models.core import Array, Image
from servosight.tracking.appearance.layers import LayerEstimator
from servosight.tracking.appearance.layers._fit import learn_layers
from servosight.tracking.appearance.layers._layers import Layers
from servosight.tracking.appearance.surface import Surface, SurfaceEstimator, single
from servosight.tracking.core import STILL
from servosight.tracking.fit import PolarGrid, rotation_axis

SHAPE = (170, 220)
PIVOT = np.array([60.3, 85.6])
BAR = np.array([[12.0, -17.0], [140.0, -17.0], [140.0, 17.0], [12.0, 17.0]])
OFF_PX = 0.1
TAUGHT = np.deg2rad(np.linspace(-12.0, 12.0, 25))
OTHERS = np.deg2rad(np.linspace(-11.7, 11.8, 40))


def printed(seed: int, size: float, x: Array, y: Array) -> Array:
    """Forty waves of 5 to 40 px, summed at the places themselves: nothing is resampled."""
    rng = np.random.default_rng(seed)
    wave, way, phase = rng.uniform((5.0, 0.0, 0.0), (40.0, 6.28, 6.28), (40, 3)).T
    along = np.cos(way)[:, None, None] * x + np.sin(way)[:, None, None] * y
    waves = np.cos(2 * np.pi / wave[:, None, None] * along + phase[:, None, None])
    return np.asarray(size * np.sqrt(2.0 / 40.0) * waves.sum(0))


def drawn(angle: float) -> Image:
    """A printed bar with soft edges on a printed bench, without noise, at an angle [rad]."""
    y, x = np.indices(SHAPE).astype(float)
    across, down = x - PIVOT[0], y - PIVOT[1]
    u = np.cos(angle) * across - np.sin(angle) * down
    v = np.sin(angle) * across + np.cos(angle) * down
    (low, top), (high, bottom) = BAR.min(0), BAR.max(0)
    edges = np.array([u - low, high - u, v - top, bottom - v])
    cover = (0.5 + 0.5 * erf(edges)).prod(0)
    bench, bar = 110.0 + printed(1, 12.0, x, y), 130.0 + printed(2, 22.0, u, v)
    return np.asarray(np.rint(bench + cover * (bar - bench)), np.uint8)


@pytest.fixture(scope="module")
def learnt() -> tuple[Surface, Layers]:
    grid = PolarGrid((PIVOT[0] + OFF_PX, PIVOT[1]), 4.0, 0.8, -0.9, 0.8 / 150.0, 180, 340)
    x, y = grid.points(0.0)
    corner, far = PIVOT + BAR.min(0), PIVOT + BAR.max(0)
    mask = (x > corner[0]) & (x < far[0]) & (y > corner[1]) & (y < far[1])
    surface = replace(single(drawn(0.0), mask, grid), outline_px=BAR + PIVOT)
    images = [drawn(angle) for angle in TAUGHT]
    light = np.tile([1.0, 0.0], (TAUGHT.size, 1))
    return surface, learn_layers(images, TAUGHT, [STILL] * TAUGHT.size, light, surface, 0.3)


def test_the_layers_settle(learnt: tuple[Surface, Layers]) -> None:
    """Eight bits leave 0.29; what a pivot that is off by 0.1 px smears comes to it."""
    assert learnt[1].noise < 0.42


def test_a_pivot_that_is_off_is_told_whole(learnt: tuple[Surface, Layers]) -> None:
    """To 0.025 px, three times what its covariance says: near the pivot, layers finer than the
    pixels kept nearly all of it."""
    surface, layers = learnt
    stage = LayerEstimator.of(layers, SurfaceEstimator.of(surface, SHAPE))
    fits = [stage.fit_near(drawn(angle), float(angle), STILL) for angle in OTHERS]
    told = [(fit.angle_rad, fit.sensitivity) for fit in fits if fit and fit.sensitivity]
    assert len(told) == OTHERS.size
    found = rotation_axis(np.array([angle for angle, _ in told]), [one for _, one in told])
    assert found is not None
    np.testing.assert_allclose(found.error_px, [-OFF_PX, 0.0], atol=0.025)
