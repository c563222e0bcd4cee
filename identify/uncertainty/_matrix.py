"""A symmetric matrix over named parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array


@dataclass(frozen=True, eq=False)
class Matrix:
    """``values`` (names, names), NaN where a parameter is undetermined.

    >>> import numpy as np
    >>> Matrix(("k", "T"), np.array([[4.0, 1.0], [1.0, 1.0]])).correlation.values.tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """

    names: tuple[str, ...]
    values: Array

    @property
    def correlation(self) -> Matrix:
        """This covariance as correlation coefficients."""
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = np.sqrt(np.diag(self.values))
            return Matrix(self.names, self.values / np.outer(sigma, sigma))
