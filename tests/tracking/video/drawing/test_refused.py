"""The picture of a refusal marks what moves, whatever the light does."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.video.drawing import refusal_picture

BACKGROUND = np.random.default_rng(5).normal(100.0, 30.0, (12, 16)).repeat(20, 0).repeat(20, 1)


def scene(gain: float, offset: float, left: int) -> Image:
    """A background with a bright square whose left side is at a column, in some light."""
    seen = BACKGROUND.copy()
    seen[100:140, left : left + 40] = 230.0
    return np.clip(gain * seen + offset, 0.0, 255.0).astype(np.uint8)


def red(picture: Image) -> Mask:
    """Where a picture is tinted: the frame about what stands out has more green."""
    _, green, above = np.moveaxis(picture.astype(int), -1, 0)
    return np.asarray(above > green + 60)


def test_the_light_of_the_whole_picture_is_no_motion() -> None:
    """The square moves by 60 px while the light fades to 0.7: only where it was or is, is red."""
    frames = [scene(1.0 - 0.05 * n, 4.0 * n, 60 + 10 * n) for n in range(7)]
    marked = red(refusal_picture(frames))
    passed = np.zeros_like(marked)
    passed[95:145, 55:165] = True
    assert marked[110:130, 70:150].mean() > 0.8
    assert not marked[~passed].any()


def test_a_picture_without_contrast_is_drawn() -> None:
    flat = np.full((240, 320), 90, np.uint8)
    assert not red(refusal_picture([flat, flat + 50])).any()
