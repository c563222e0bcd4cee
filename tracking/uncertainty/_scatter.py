"""Scatter of angles from frame to frame: what differences of a high order leave of a motion."""

from __future__ import annotations

from math import comb

import numpy as np
from scipy import ndimage

from servosight.models.core import Array, rms

EIGHTH = 8
"""The order of differences that leaves little of a motion slower than a twentieth of the rate."""

MOTION = 4.5
"""Times the usual scatter: more is taken for motion; of composed clips the errors reach 4.1."""

FEWEST = 30  # differences
_MEDIAN = 0.6745  # median of the absolute value of unit normal scatter
_USUAL, _ROUNDS = 3.0, 8
_NEAR = 15  # frames over which scatter is averaged
_COPIED = 0.1  # of the error that residuals show
_OUTLYING = 3.5  # times the neighbours' scatter


def differences(angle: Array, order: int = EIGHTH, stride: int = 1) -> Array:
    """Differences over ``stride`` frames, scaled so that those of white noise are as large as it;
    (frames - order x stride,).

    >>> differences(np.array([0.0, 1.0, 0.0]), 2).round(3)
    array([-0.816])
    """
    weights = np.array([(-1) ** n * comb(order, n) for n in range(order + 1)], np.float64)
    count = angle.size - order * stride
    parts = [w * angle[n * stride : n * stride + count] for n, w in enumerate(weights)]
    return np.asarray(np.sum(parts, axis=0) / np.sqrt((weights**2).sum()))


def usual_size(size: Array) -> float:
    """The rms of differences, without outlying ones: a start or a stop."""
    size = np.abs(size)
    for _ in range(_ROUNDS):
        size = size[size <= _USUAL * float(np.median(size)) / _MEDIAN]
    return rms(size)


def even_scatter(angle: Array) -> float:
    """The scatter of angles (frames,) from frame to frame about a motion that is slower than a
    twentieth of the frame rate, the same for all; 0 where there are too few.

    >>> even_scatter(np.sin(np.arange(60) / 9.0)) < 1e-7
    True
    """
    return usual_size(differences(angle)) if angle.size >= EIGHTH + FEWEST else 0.0


def scatter(angle: Array, shown: float = 0.0) -> Array:
    """Scatter of each angle from frame to frame about the motion; (frames,).

    By eighth differences: the mean square over some neighbours, at least that of neighbours and all
    frames together, since a codec's errors that last for some frames hardly scatter there. What is
    far larger than the usual difference is the motion's and counts as the usual one: a servo's
    steps at 60 frames/s leave a hundred times a codec's errors in a tenth of the frames.

    ``shown`` is the error that the residuals show. What is as large is an error's in any case, and
    what is a small part of it is a picture at rest that the codec copied, which says nothing of the
    usual difference: a part may rest in most of the frames.
    """
    size = np.abs(differences(angle))
    fresh = size[size >= _COPIED * shown]
    usual = usual_size(fresh if fresh.size >= FEWEST else size)
    reach = min(_NEAR, size.size)
    near = ndimage.median_filter(size, reach, mode="nearest") / _MEDIAN
    limited = np.minimum(size, _OUTLYING * near)
    own = np.where(limited > MOTION * max(usual, shown), usual, limited) ** 2
    local = ndimage.uniform_filter1d(own, reach, mode="nearest")
    shared = 0.5 * (local + own.mean())
    return np.asarray(np.pad(np.sqrt(np.maximum(local, shared)), EIGHTH // 2, "edge"))
