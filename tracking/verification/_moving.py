"""Which frames show most of a part that rests nearly always: a few steps, a swing, then nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from servosight.models.core import Mask
from servosight.tracking.core import known_median
from servosight.tracking.verification._pairs import smallest_change
from servosight.tracking.verification._sample import FrameSample
from servosight.tracking.video import Frame

_LEAST_SHARE = 0.0005  # of a picture's pixels
_RARELY = 0.25  # of the sampled pictures
_MOVING, _RESTING = 64, 16


def sampled_where_it_moves(
    sample: FrameSample, again: Callable[[], Iterable[Frame]]
) -> FrameSample:
    """A sample with most frames from where the pictures of ``sample`` change, and some others; the
    given one where they change often, or never. ``again`` gives all frames once more."""
    if sample.stride == 1:  # there are no other frames
        return sample
    away = differing(sample)
    if not away.any() or away.mean() > _RARELY:
        return sample
    index = np.array(sample.index)
    last = int(index[-1]) + sample.stride
    moving = np.zeros(last, bool)
    for row in np.flatnonzero(away).tolist():
        # It began to move, or came to rest, between two of them.
        moving[index[max(row - 1, 0)] : index[row] + sample.stride] = True
    frames = np.flatnonzero(moving)
    frames = frames[:: -(-frames.size // _MOVING)]
    rest = index[~away]
    rest = rest[:: -(-rest.size // _RESTING)]
    closer = FrameSample(sample.prepare, only=frozenset({int(index[0]), *frames, *rest}))
    for frame in again():
        closer.add(frame)
    return closer


def differing(sample: FrameSample) -> Mask:
    """The sampled pictures (n,) that differ from the median one by more than noise."""
    pictures = np.stack(sample.pictures)[:, ::2, ::2]
    away = np.abs(pictures - known_median(pictures))
    share = (away > smallest_change(away)).mean((1, 2))
    return np.asarray(share > _LEAST_SHARE)
