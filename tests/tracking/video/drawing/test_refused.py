"""The picture of a refusal marks what moves, whatever the light does."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Image, Mask
from servosight.tracking.video.drawing import SeenPart, refusal_picture
from servosight.tracking.video.drawing._canvas import Canvas

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


def test_light_that_changes_on_one_side_is_no_motion() -> None:
    """As a shadow that falls over half of the picture."""
    side = np.clip(np.linspace(1.4, 0.6, 320), 0.6, 1.0)
    frames = [scene(1.0, 0.0, 60 + 10 * n) for n in range(7)]
    frames = [
        np.asarray(one * (1.0 + n / 6 * (side - 1.0)), np.uint8) for n, one in enumerate(frames)
    ]
    marked = red(refusal_picture(frames))
    passed = np.zeros_like(marked)
    passed[95:145, 55:165] = True
    assert marked[110:130, 70:150].mean() > 0.8
    assert marked[~passed].mean() < 0.02


@pytest.mark.parametrize("times", [0.2, 1.0, 8.0])
def test_words_can_be_read_in_pictures_of_any_size(times: float) -> None:
    """Their height is 1 % to 8 % of the shorter side; a small picture is enlarged."""
    frames = [scene(1.0, 0.0, 60 + 10 * n) for n in range(3)]
    sized = [cv2.resize(one, None, fx=times, fy=times) for one in frames]
    x, y = 200.0 * times, 180.0 * times
    part = SeenPart((x, y), np.array([[x, y], [x + 20 * times, y], [x, y + 20 * times]]))
    drawn = refusal_picture(sized, [part]).astype(int)
    assert max(drawn.shape) >= 320
    green = (drawn[:, :, 1] > drawn[:, :, 2] + 60) & (drawn[:, :, 1] > drawn[:, :, 0] + 60)
    count, _, stats, _ = cv2.connectedComponentsWithStats(green.astype(np.uint8))
    heights = stats[1:count, cv2.CC_STAT_HEIGHT] / min(drawn.shape[:2])
    assert 0.008 < np.quantile(heights, 0.6) < 0.08


def test_words_do_not_cover_each_other() -> None:
    canvas = Canvas.of(np.zeros((240, 320), np.uint8))
    for number in range(6):
        canvas.write(f"--pick {number} or --pivot 300,235", (300, 235 + number), (255, 255, 255))
    for number, (left, top, right, bottom) in enumerate(canvas.written):
        assert left >= 0
        assert right <= 320
        assert top >= 0
        assert bottom <= 240
        for other in canvas.written[:number]:
            assert bottom <= other[1] or top >= other[3]


def test_what_reaches_the_border_does_not_stand_out_before_a_whole_part() -> None:
    """As the edge of a bar beside the picture of a held camera."""
    frames = [scene(1.0, 0.0, 60 + 10 * n) for n in range(7)]
    for number, frame in enumerate(frames):
        frame[:, : 20 if number else 8] = 0
    blue, green, _ = np.moveaxis(refusal_picture(frames).astype(int), -1, 0)
    framed = green > blue + 60
    assert framed[95:145, 50:110].any()
    assert not framed[200:].any()
