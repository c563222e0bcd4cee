"""Blocks that a codec only copied: seen as such, left out, and in sigma where nothing else is."""

from __future__ import annotations

import numpy as np

from servosight.tracking.fit import NONE_STALE, Pixels, PolarGrid, Sample, lag, stale
from servosight.tracking.fit._copied import copied_pixels

SHAPE = (52, 60)  # no whole number of blocks


def pictures() -> tuple[np.ndarray, np.ndarray]:
    """Two noisy pictures, the same in the left half."""
    rng = np.random.default_rng(1)
    one, other = rng.integers(40, 200, (2, *SHAPE)).astype(np.uint8)
    other[:, :32] = one[:, :32]
    return one, other


def test_copied_blocks_are_those_that_stayed_the_same() -> None:
    copied = copied_pixels(*pictures())
    assert copied.shape == SHAPE
    assert copied[:, :32].all()
    assert not copied[:, 32:].any()


def sample() -> Sample:
    grid = PolarGrid((5.0, 5.0), 0.0, 1.0, 0.0, 0.02, 60, 60)
    pixels = Pixels.about(grid, SHAPE)
    chosen = np.arange(pixels.index.size // 2)
    ones = np.ones(chosen.size, np.float32)
    return Sample(pixels, chosen, ones, ones, ones[:0])


def test_old_pixels_are_left_out_unless_they_are_all_there_is() -> None:
    copied = copied_pixels(*pictures())
    old, share = stale(sample, copied)
    np.testing.assert_array_equal(old, copied.ravel())
    assert share == 0.0
    none, share = stale(sample, np.ones(SHAPE, bool))
    assert (none.size, share) == (0, 1.0)
    assert stale(sample, None) == (NONE_STALE, 0.0)


def test_lag_grows_with_the_turn_since_the_picture_was_new() -> None:
    """Frames 4 and 5 repeat frame 3 of an even turn: one step behind, and two."""
    held = np.zeros(9)
    held[4:6] = 1.0
    angle = np.arange(9.0)
    angle[4:6] = 3.0
    np.testing.assert_allclose(lag(angle, held), [0, 0, 0, 0, 1, 2, 0, 0, 0], atol=1e-12)
    assert not lag(np.zeros(9), held).any()
