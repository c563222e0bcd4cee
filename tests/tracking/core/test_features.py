"""Features are looked for where a video's pictures differ, and are where they are in the whole."""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Image
from servosight.tracking.core import Features

SHAPE = (240, 320)
PART = slice(90, 150), slice(180, 260)  # rows and columns
ROOM_PX = 40  # the part's own, and that of a feature


def printed(seed: int) -> Image:
    """Blurred noise: texture everywhere."""
    noise = np.random.default_rng(seed).uniform(0.0, 255.0, SHAPE)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 2.0) * 6.0 - 640.0).clip(0, 255).astype("u1")


def pictures() -> list[Image]:
    """The same bench with three prints in one place."""
    bench = printed(1)
    shown = [bench.copy() for _ in range(3)]
    for seed, image in enumerate(shown, 2):
        image[PART] = printed(seed)[PART]
    return shown


def test_features_lie_about_what_changes() -> None:
    images = pictures()
    points = Features(images).points_px(images[0])
    assert len(points) > 20
    rows, columns = PART
    low = np.array([columns.start, rows.start]) - ROOM_PX
    high = np.array([columns.stop, rows.stop]) + ROOM_PX
    assert ((points > low) & (points < high)).all()


def test_a_feature_is_where_it_is_in_the_whole_picture() -> None:
    """To 0.05 px for most: the pyramid's coarser levels begin at another pixel."""
    images = pictures()
    some, every = Features(images).points_px(images[0]), Features().points_px(images[0])
    apart = np.hypot(*(some[:, None] - every).transpose(2, 0, 1)).min(1)
    assert np.median(apart) < 0.05


def test_where_nothing_changes_the_whole_picture_is_searched() -> None:
    image = printed(1)
    same = Features([image, image.copy()]).points_px(image)
    np.testing.assert_array_equal(same, Features().points_px(image))
