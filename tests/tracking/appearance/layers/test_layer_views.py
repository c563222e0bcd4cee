"""A frame's share of the linear problem: its transpose, and its slopes against small turns."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.appearance.layers._frame_pixels import FramePixels
from servosight.tracking.core import STILL, Exposure
from servosight.tracking.fit import Pixels, PolarGrid

GRID = PolarGrid((20.0, 60.0), 10.0, 1.0, -0.4, 0.02, 60, 40)
SHAPE = (120, 100)
PIXELS = Pixels.about(GRID, SHAPE)
WANTED = np.ones((GRID.columns, GRID.rows), np.uint8)
UNEVEN = Exposure(0.01, 0.05, 0.02, np.array([-0.012, 0.001, 0.011]))


def layers(seed: int) -> np.ndarray:
    """Smooth random layers that vanish at the border, where a smear would reach beyond them."""
    rng = np.random.default_rng(seed)
    free = np.zeros((GRID.columns, GRID.rows, 2), np.float32)
    free[6:-6, 6:-6] = rng.standard_normal((GRID.columns - 12, GRID.rows - 12, 2))
    return free


def shown(frame: FramePixels, x: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """What the frame's pixels show of layers before a bench."""
    light, clear, _, _ = frame.linear(x)
    return np.asarray(light + clear * behind)


@pytest.mark.parametrize("exposure", [STILL, UNEVEN], ids=["still", "uneven"])
def test_spread_is_the_transpose_of_what_is_shown(exposure: Exposure) -> None:
    """<A x, y> = <x, A' y>, to the rounding of single precision."""
    frame = FramePixels.of(PIXELS, GRID, 0.1, exposure, WANTED)
    rng = np.random.default_rng(3)
    grey, behind = rng.standard_normal((2, frame.index.size)).astype(np.float32)
    x = layers(4)
    there = float(shown(frame, x, behind) @ grey)
    onto = np.zeros_like(x)
    frame.spread(grey, behind, onto)
    back = float((x * onto).sum())
    assert there == pytest.approx(back, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("exposure", [STILL, UNEVEN], ids=["still", "uneven"])
def test_bent_is_what_is_shown_weighted_and_spread(exposure: Exposure) -> None:
    """A' W (A x + R' o) and R W (A x + R' o), to the rounding of single precision."""
    frame = FramePixels.of(PIXELS, GRID, 0.1, exposure, WANTED)
    rng = np.random.default_rng(6)
    rows = rng.standard_normal((3, frame.index.size)).astype(np.float32)
    behind, weight = rng.uniform(0.5, 1.0, (2, frame.index.size)).astype(np.float32)
    own, x = np.array([0.5, -1.0, 2.0], np.float32), layers(7)
    grey = weight * (shown(frame, x, behind) + own @ rows)
    expected, found = np.zeros_like(x), np.zeros_like(x)
    frame.spread(grey, behind, expected)
    by_own = frame.bent(x, behind, (rows, own), weight, found)
    np.testing.assert_allclose(found, expected, atol=1e-4)
    np.testing.assert_allclose(by_own, rows @ grey, rtol=1e-3)


@pytest.mark.parametrize("exposure", [STILL, UNEVEN], ids=["still", "uneven"])
def test_linear_tells_how_what_is_shown_changes(exposure: Exposure) -> None:
    """Slope by column against a turn by a hundredth of one: second differences are 1e-4."""
    x = layers(5)
    frame = FramePixels.of(PIXELS, GRID, 0.1, exposure, WANTED)
    behind = np.full(frame.index.size, 2.0, np.float32)
    _, _, by_light, by_clear = frame.linear(x)
    ahead = frame.where + np.array([[0.01], [0.0]], np.float32)
    behind_it = frame.where - np.array([[0.01], [0.0]], np.float32)
    moved = [
        shown(FramePixels(frame.index, place, frame.smear, frame.parts), x, behind)
        for place in (ahead, behind_it)
    ]
    inside = (frame.where[0] > 3) & (frame.where[0] < GRID.columns - 4)
    slope = (moved[0] - moved[1])[inside] / 0.02
    np.testing.assert_allclose((by_light + 2.0 * by_clear)[inside], slope, atol=5e-3)
