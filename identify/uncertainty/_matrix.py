"""A symmetric matrix over named parameters, and the inverse of what the data determine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Frozen, html_table

_FLAT = 1e-13


@dataclass(frozen=True, eq=False)
class Matrix(Frozen):
    """``values`` (names, names), NaN where a parameter is undetermined.

    >>> import numpy as np
    >>> Matrix(("k", "T"), np.array([[4.0, 1.0], [1.0, 1.0]])).correlation.values.tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    >>> np.asarray(Matrix(("k",), np.array([[4.0]]))).shape
    (1, 1)
    """

    names: tuple[str, ...]
    values: Array

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Its ``values``, for numpy."""
        return np.array(self.values, dtype=dtype, copy=copy)

    def _repr_html_(self) -> str:
        rows = [
            {"": name, **dict(zip(self.names, map(float, row), strict=True))}
            for name, row in zip(self.names, self.values, strict=True)
        ]
        return html_table(rows)

    @property
    def correlation(self) -> Matrix:
        """This covariance as correlation coefficients."""
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = np.sqrt(np.diag(self.values))
            return Matrix(self.names, self.values / np.outer(sigma, sigma))


def determined_inverse(jacobian: Array, free: NDArray[np.bool_]) -> Array:
    """(J'J)^-1 from the eigenvalues of J'J with columns scaled to one.

    They are known to 1e-15 of the largest, J's difference quotients to less.
    """
    count = jacobian.shape[1]
    result = np.full((count, count), np.nan)
    norms = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    columns = np.flatnonzero(free & (norms > 0.0))
    if columns.size == 0:
        return result
    norms = norms[columns]
    scaled = jacobian[:, columns] / norms
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    keep = values > _FLAT * values[-1]
    inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T / np.outer(norms, norms)
    # A coordinate with a part in a flat direction is undetermined.
    lost = np.sum(vectors[:, ~keep] ** 2, axis=1) > 1e-6
    inverse[lost, :] = np.nan
    inverse[:, lost] = np.nan
    result[np.ix_(columns, columns)] = inverse
    return result


def inverse_within(
    jacobian: Array,
    point: Array,
    bounds: tuple[Array, Array],
    own: NDArray[np.bool_],
    variance: float,
) -> Array:
    """(J'J)^-1 of a fit within ``bounds`` at ``point``, NaN where a coordinate is undetermined.

    One that rests on a bound is uncertain inward, and those that can stand in for it are as well:
    it counts as free, unless they would be undetermined then. ``own`` coordinates of a recording
    on a bound count as known. So does any of both whose sigma exceeds its whole range, such as
    the initial speed of a motor within its play: what follows it linearly so far would leave the
    range, and the others hardly depend on it. ``variance`` of the residuals [deg^2].
    """
    low, high = bounds
    inside = (point > low) & (point < high)
    resting = ~own & ~inside & (low < high)
    free = inside | resting
    found = determined_inverse(jacobian, free)
    wide = (own | resting) & (variance * np.nan_to_num(np.diag(found)) > (high - low) ** 2)
    if wide.any():
        found = determined_inverse(jacobian, free & ~wide)
    alone = determined_inverse(jacobian, inside & ~wide) if resting.any() else found
    lost = np.isfinite(np.diag(alone)) & np.isnan(np.diag(found))
    return alone if lost.any() else found
