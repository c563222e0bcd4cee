"""The usual size of errors some of which are far off."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array


def limited_rms(error: Array, quantile: float, times: float) -> float:
    """The rms of errors (n,) that count as ``times`` this quantile of their sizes at most: of a few
    that are far off, as where a hand hides a part, the size says nothing. 0 of none.

    >>> limited_rms(np.array([1.0, -1.0, 1.0, 100.0]), 0.5, 5.0)
    2.6457513110645907
    """
    if error.size == 0:
        return 0.0
    size = np.abs(error)
    limited = np.minimum(size, times * np.quantile(size, quantile))
    return float(np.sqrt(np.mean(limited**2)))
