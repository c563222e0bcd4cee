"""Frames are kept evenly from a whole video, however many it has."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Image
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import Frame

FLAT = np.zeros((12, 16), np.uint8)


@pytest.mark.parametrize("count", [1, 40, 95, 96, 97, 1000, 5000])
def test_a_sample_of_a_known_count_is_the_same_and_prepares_no_more(count: int) -> None:
    prepared = []

    def prepare(image: Image) -> Image:
        prepared.append(image)
        return image

    samples = FrameSample(lambda image: image), FrameSample.of_video(prepare, count)
    for sample in samples:
        for _ in sample.watch(Frame(n, n / 100.0, FLAT) for n in range(count)):
            pass
    assert samples[0].index == samples[1].index
    assert len(prepared) == len(samples[1].index) < 96
    assert len(samples[1].index) >= min(count, 48)


def test_a_video_longer_than_its_header_says_stays_small() -> None:
    sample = FrameSample.of_video(lambda image: image, 10)
    for _ in sample.watch(Frame(n, n / 100.0, FLAT) for n in range(2000)):
        pass
    assert 48 <= len(sample.index) < 96
    assert sample.index[-1] > 1900
