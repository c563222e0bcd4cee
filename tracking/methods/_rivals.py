"""Two explanations of one motion: the one that leaves less when both are learnt in full.

A plain part that rests at two angles is mapped onto itself by turns about several pivots. In the
small pictures in which parts are looked for these explain nearly the same: a flap that swings
through 84 deg, 81 % about its hinge and 82 % about a point beside it, by 33 deg.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np

from servosight.models.core import Array, Mask
from servosight.tracking.composite import (
    FoundPart,
    PartMeter,
    StabilisedSample,
    outline_of,
)
from servosight.tracking.core import threaded

_ABOUT = 0.9  # of what the first one explains
_SAME = 0.3  # of the smaller one's area lies in the other: elsewhere another part turns
_MOST = 3


def best_first(
    stabilised: StabilisedSample, parts: Sequence[FoundPart],
    settled: Callable[[FoundPart], tuple[FoundPart, PartMeter]],
) -> list[FoundPart]:  # fmt: skip
    """The parts with the first one and those that explain about as much of the same change in the
    order of what is left once each is learnt about its own pivot, as ``settled`` does; the others
    as they were."""
    about = [
        number
        for number, part in enumerate(parts[:_MOST])
        if part.explained_there >= _ABOUT * parts[0].explained_there
    ]
    if len(about) < 2:
        return list(parts)
    shapes = [_filled(outline_of(parts[number], stabilised), stabilised) for number in about]
    rivals = [
        number
        for number, shape in zip(about, shapes, strict=True)
        if _shared(shapes[0], shape) > _SAME
    ]
    if len(rivals) < 2:
        return list(parts)
    learnt = threaded(settled, [parts[number] for number in rivals])
    gains = [meter.gain for _, meter in learnt]
    order = [rivals[place] for place in np.argsort(gains)[::-1]]
    return [parts[n] for n in (*order, *(n for n in range(len(parts)) if n not in rivals))]


def _filled(outline: Array, stabilised: StabilisedSample) -> Mask:
    """The area inside an outline (points, 2), of the pictures' size."""
    area = np.zeros(stabilised.content.shape, np.uint8)
    if len(outline):
        cv2.fillPoly(area, [np.round(outline).astype(np.int32)], 1)
    return np.asarray(area > 0)


def _shared(one: Mask, other: Mask) -> float:
    """The share of the smaller of two areas that lies in the other."""
    return float((one & other).sum() / max(min(one.sum(), other.sum()), 1))
