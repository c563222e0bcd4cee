"""The camera's clock from a recorded video: the light found in it, and its code read."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from servosight.bench.camera import Footage
from servosight.bench.timing import (
    ClockFit,
    LightPattern,
    SeenLight,
    block_means,
    decode,
    even_stamps,
    find_light,
)
from servosight.models.core import Array, Image, InputError, Single

_SEARCHED = 1200  # frames in which the light is looked for
_REACH_S = 1.0  # a camera's latency is less
_NEAR_S = 0.1


def read_light(video: Path, footage: Footage, pattern: LightPattern) -> tuple[ClockFit, SeenLight]:
    """Clock and light of a recorded video; InputError where no light follows the pattern.

    The clock turns the footage's stamps into mid-exposure times, of the light's own row, on the
    clock of the pattern.
    """
    stamps = steady_stamps(footage)
    count = min(stamps.size, _SEARCHED)
    pictures = list(islice(_blocks(video), count))
    _check_count(video, len(pictures), count)
    blocks = np.stack(pictures)
    # The shortest delay to the host is the clocks' offset and the latency.
    seen = find_light(stamps[:count], blocks, pattern, guess_s=footage.delay_s, reach_s=_REACH_S)
    if seen is None:
        raise InputError(
            "no part of the picture follows the coded light; bring the light into the picture, "
            "some 10 x 10 pixels large and not overexposed"
        )
    level = seen.level
    if stamps.size > count:
        level = np.array([float((means * seen.weights).sum()) for means in _blocks(video)])
        _check_count(video, level.size, stamps.size)
    fit = decode(
        stamps,
        level,
        pattern,
        exposure_s=footage.stream.exposure_s,
        guess_s=seen.offset_s,
        reach_s=_NEAR_S,
    )
    return fit, seen


def _check_count(video: Path, found: int, expected: int) -> None:
    if found != expected:
        raise InputError(
            f"{video.name}: {found} of {expected} pictures can be decoded, so that the light "
            "cannot be read off it; check the camera's cable and link"
        )


def steady_stamps(footage: Footage) -> Array:
    """The stamps; those of arrival without the jitter of delivery, where the rate is even."""
    if footage.stream.meaning == "arrival":
        return even_stamps(footage.stamp_s)
    return footage.stamp_s


def _blocks(video: Path) -> Iterator[Single]:
    """Block means of each picture, all of one size; InputError where the video is damaged."""
    import av

    shape: tuple[int, ...] | None = None
    try:
        with av.open(str(video)) as container:
            for picture in container.decode(video=0):
                image: Image = np.asarray(picture.to_ndarray(format="gray"), np.uint8)
                if image.shape != (shape or image.shape):
                    raise ValueError("its pictures change their size")
                shape = image.shape
                yield block_means(image)
    except (av.FFmpegError, ValueError) as error:
        raise InputError(f"{video.name}: the light cannot be read off it ({error})") from None
