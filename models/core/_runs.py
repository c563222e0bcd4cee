"""Stretches of neighbouring samples that have something in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from servosight.models.core._arrays import Mask


def runs_of(mask: Mask) -> NDArray[np.intp]:
    """First sample and end (exclusive) of each run of True in a mask (samples,), (runs, 2).

    >>> runs_of(np.array([True, False, True, True])).tolist()
    [[0, 1], [2, 4]]
    """
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return edges.reshape(-1, 2)
