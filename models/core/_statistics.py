"""Statistics that several stages share."""

from __future__ import annotations

import numpy as np

from servosight.models.core._arrays import Array

CHI_SQUARE_95 = 3.841
"""The 95 % quantile of chi-square with one degree of freedom: at either end of the 95 % interval of
one number the log-likelihood is lower by half of it."""


def rms(values: Array) -> float:
    """Root mean square of ``values``, of any shape.

    >>> rms(np.array([3.0, 4.0])) == 12.5**0.5
    True
    """
    return float(np.sqrt(np.mean(values**2)))
