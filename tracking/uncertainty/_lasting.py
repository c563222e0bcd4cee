"""By how much errors that last for some frames exceed their scatter from frame to frame."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.tracking.uncertainty._scatter import (
    EIGHTH,
    FEWEST,
    MOTION,
    differences,
    scatter,
    usual_size,
)

_STRIDES = (1, 2, 3, 4)  # frames
_LOW = 6  # the order beside the eighth
_ALIKE = 1.15
_ALIKE_OF_NEIGHBOURS = 1.3  # errors that last may themselves decrease with the order


def with_scatter(sigma: Array, angle: Array) -> Array:
    """Sigma (frames,) of angles (frames,) where ``sigma``, of the residuals, is not all of it.

    Scatter adds to it. Errors that last are seen in the residuals in part: where all of them are
    usually larger than both together, sigma is so much larger.
    """
    near = scatter(angle, float(np.median(sigma)))
    both = np.hypot(sigma, near)
    usual = float(np.median(both))
    larger = lasting(angle) * float(np.median(near)) / usual if usual > 0.0 else 1.0
    return np.asarray(max(larger, 1.0) * both)


def lasting(angle: Array) -> float:
    """The factor, 1 at least, by which the error of angles (frames,) exceeds their scatter.

    A predicting codec corrects a block only some frames after it began to be wrong, and the motion
    of a background that it copies is measured too small: neighbouring frames share such an error,
    and differences between them are too small by it. Differences over two to four frames contain
    it. They contain motion as well, but unlike noise that changes with the order of the
    difference: strides count up to the first at which two orders differ, or at which the scatter
    is so large that it must be motion. A sudden motion is outlying, in one order more than in the
    other. Of white noise the factor is 1.14 in the mean on 120 frames, 1.06 on 600.
    """
    sizes: list[float] = []
    for stride in _STRIDES:
        if angle.size < EIGHTH * stride + FEWEST:
            break
        low, high = (usual_size(differences(angle, n, stride)) for n in (_LOW, EIGHTH))
        alike = _ALIKE if sizes else _ALIKE_OF_NEIGHBOURS
        if max(low, high) > alike * min(low, high) or (sizes and high > MOTION * sizes[0]):
            break
        sizes.append(high)
    return max(sizes) / sizes[0] if sizes and sizes[0] > 0.0 else 1.0
