"""What a wrong time, the same for all frames, does to their angles."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Mask


def by_delay(angle: Array, time_s: Array, found: Mask, sigma_s: float) -> Array:
    """Change of angles (frames,) with one sigma of a delay that all frames share; (frames, 1).

    Zero in frames in which no angle is ``found``.

    >>> time_s = np.array([0.0, 0.1, 0.2])
    >>> by_delay(np.array([0.0, 2.0, 4.0]), time_s, np.ones(3, bool), 0.01).ravel().tolist()
    [0.2, 0.2, 0.2]
    """
    change = np.zeros((angle.size, 1))
    if np.count_nonzero(found) > 1:
        change[found, 0] = sigma_s * np.gradient(angle[found], time_s[found])
    return change
