"""A smaller part beside the one that explains most is found as well, and nothing where none is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Single
from servosight.tracking.composite import find_parts

LARGE_PX, SMALL_PX = (70.0, 75.0), (175.0, 68.0)
COUNT = 24


def with_arm(
    pictures: Single, pivot_px: tuple[float, float], length_px: float, grey: float, angle_rad: Array
) -> None:
    """Draw a plain arm into each of the pictures (n, height, width), in place."""
    for picture, angle in zip(pictures, angle_rad, strict=True):
        tip = np.array(pivot_px) + length_px * np.array([np.cos(angle), -np.sin(angle)])
        ends = [tuple(int(v) for v in np.round(16 * np.array(p))) for p in (pivot_px, tip)]
        cv2.line(picture, ends[0], ends[1], grey, 6, cv2.LINE_AA, 4)


def scene(small: bool) -> Single:
    rng = np.random.default_rng(6)
    still = 90.0 + 12.0 * cv2.GaussianBlur(rng.standard_normal((135, 240)), (0, 0), 3.0) * 6.0
    pictures = np.repeat(still[None], COUNT, 0).astype(np.float32)
    time = np.arange(COUNT) / COUNT
    with_arm(pictures, LARGE_PX, 55.0, 220.0, 0.3 + 0.8 * np.sin(2 * np.pi * time))
    if small:
        with_arm(pictures, SMALL_PX, 38.0, 120.0, 2.0 + 0.5 * np.sin(4 * np.pi * time + 1.0))
    return np.asarray(pictures + rng.standard_normal(pictures.shape), np.float32)


@pytest.mark.parametrize("small", [True, False])
def test_a_smaller_part_is_named_and_no_phantom(small: bool) -> None:
    """The small arm is 3 % of the squared change. Bound: 3 px of its pivot."""
    found = find_parts(scene(small))
    assert np.hypot(*np.subtract(found[0].pivot_px, LARGE_PX)) < 3.0
    beside = [one for one in found if one.beside is not None]
    assert bool(beside) == small
    if small:
        assert np.hypot(*np.subtract(beside[0].pivot_px, SMALL_PX)) < 3.0
        assert beside[0].explained < 0.1 < 0.65 < beside[0].explained_there
        assert all(0.0 <= one.pivot_px[0] < 240.0 for one in beside)
