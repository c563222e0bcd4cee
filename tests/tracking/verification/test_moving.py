"""Which frames of a part that rests nearly always are looked at."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from servosight.models.core import Array
from servosight.tracking.verification import FrameSample, sampled_where_it_moves
from servosight.tracking.video import Frame

FRAMES = 1000


def frames(angle_deg: Array) -> Iterator[Frame]:
    """A bar that turns by these angles, with noise."""
    rng = np.random.default_rng(3)
    for index, angle in enumerate(np.deg2rad(angle_deg)):
        image = np.full((60, 80), 90.0, np.float32)
        end = (round(40 + 25 * float(np.cos(angle))), round(30 - 25 * float(np.sin(angle))))
        cv2.line(image, (40, 30), end, 200.0, 3)
        image += rng.standard_normal(image.shape).astype(np.float32)
        yield Frame(index, index / 100.0, np.clip(image, 0, 255).astype(np.uint8))


def sampled(angle_deg: Array) -> tuple[FrameSample, FrameSample]:
    """Evenly, and where it moves."""
    sample = FrameSample(lambda image: image)
    for frame in frames(angle_deg):
        sample.add(frame)
    return sample, sampled_where_it_moves(sample, lambda: frames(angle_deg))


def test_most_frames_are_from_where_it_moves_and_some_from_its_rest() -> None:
    angle = np.zeros(FRAMES)
    angle[400:460] = 40.0 * np.sin(np.arange(60) / 6.0)
    evenly, closer = sampled(angle)
    moving = [sum(400 <= n < 460 for n in one.index) for one in (evenly, closer)]
    assert moving[0] < 6
    assert moving[1] > 30
    assert len(closer.index) < 96
    assert closer.index[0] == 0
    assert closer.index == sorted(closer.index)
    rest = [n for n in closer.index if not 380 <= n < 480]
    assert len(rest) >= 12
    assert rest[-1] > 900


def test_a_part_that_moves_often_or_never_is_sampled_evenly() -> None:
    for angle in (40.0 * np.sin(np.arange(FRAMES) / 9.0), np.zeros(FRAMES)):
        evenly, closer = sampled(angle)
        assert closer is evenly
