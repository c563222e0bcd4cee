"""By how much errors that last for some frames exceed their scatter from frame to frame."""

from __future__ import annotations

from math import comb

import numpy as np

from servosight.models.core import Array
from servosight.tracking.uncertainty._sigma import scatter

_STRIDES = (1, 2, 3, 4)  # frames
_LOW, _HIGH = 6, 8  # orders
_ALIKE = 1.15
_ALIKE_OF_NEIGHBOURS = 1.3  # errors that last may themselves decrease with the order
_MOST = 4.5  # more is taken for motion: of composed clips the errors reach 4.1
_OUTLYING, _ROUNDS = 3.0, 8
_FEWEST = 30  # differences


def with_scatter(sigma: Array, angle: Array) -> Array:
    """Sigma (frames,) of angles (frames,) where ``sigma``, of the residuals, is not all of it.

    Scatter adds to it. Errors that last are seen in the residuals in part: where all of them are
    usually larger than both together, sigma is so much larger.
    """
    near = scatter(angle)
    both = np.hypot(sigma, near)
    usual = float(np.median(both))
    larger = lasting(angle) * float(np.median(near)) / usual if usual > 0.0 else 1.0
    return np.asarray(max(larger, 1.0) * both)


def lasting(angle: Array) -> float:
    """The factor, 1 at least, by which the error of angles (frames,) exceeds their scatter.

    A predicting codec corrects a block only some frames after it began to be wrong, and the motion
    of a background that it copies is measured too small: neighbouring frames share such an error,
    and differences between them are too small by it. Differences over two to four frames contain
    it. They contain motion as well, but unlike noise that decreases with the order of the
    difference: strides count up to the first at which two orders differ, or at which the scatter
    is so large that it must be motion. A sudden motion is outlying. Of white noise
    the factor is 1.15 in the mean on 120 frames, 1.05 on 600.
    """
    sizes: list[float] = []
    for stride in _STRIDES:
        if angle.size < _HIGH * stride + _FEWEST:
            break
        low, high = (_size(angle, order, stride) for order in (_LOW, _HIGH))
        alike = _ALIKE if sizes else _ALIKE_OF_NEIGHBOURS
        if low > alike * high or (sizes and high > _MOST * sizes[0]):
            break
        sizes.append(high)
    return max(sizes) / sizes[0] if sizes and sizes[0] > 0.0 else 1.0


def even_scatter(angle: Array) -> float:
    """The scatter of angles (frames,) from frame to frame about a motion that is slower than a
    twentieth of the frame rate, the same for all; 0 where there are too few.

    >>> even_scatter(np.sin(np.arange(60) / 9.0)) < 1e-7
    True
    """
    return _size(angle, _HIGH, 1) if angle.size >= _HIGH + _FEWEST else 0.0


def _size(angle: Array, order: int, stride: int) -> float:
    """The rms of differences over ``stride`` frames, as of one angle; without outlying ones."""
    weights = np.array([(-1) ** n * comb(order, n) for n in range(order + 1)], np.float64)
    count = angle.size - order * stride
    parts = [w * angle[n * stride : n * stride + count] for n, w in enumerate(weights)]
    size = np.abs(np.sum(parts, axis=0)) / np.sqrt((weights**2).sum())
    for _ in range(_ROUNDS):
        usual = float(np.median(size)) / 0.6745
        size = size[size <= _OUTLYING * usual]
    return float(np.sqrt(np.mean(size**2)))
