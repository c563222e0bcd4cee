"""Small normal equations inside compiled loops: a few unknowns, by Cholesky's method.

NumPy's own takes seconds to be compiled, and a lock of the interpreter where it fails.
"""

from __future__ import annotations

import numpy as np
from numba import njit

_SINGULAR = 1e-12  # what of a pivot's own term elimination may leave


@njit(cache=True, nogil=True, error_model="numpy")
def solved(matrix, side, step):  # type: ignore[no-untyped-def]
    """Whether ``matrix`` (n, n) is regular and positive; ``step`` then solves it with ``side``, by
    Cholesky's method."""
    size = side.size
    lower = np.zeros((size, size))
    for i in range(size):
        for j in range(i + 1):
            rest = matrix[i, j]
            for m in range(j):
                rest -= lower[i, m] * lower[j, m]
            if i == j:
                if not rest > _SINGULAR * matrix[i, i]:
                    return False
                lower[i, i] = np.sqrt(rest)
            else:
                lower[i, j] = rest / lower[j, j]
    for i in range(size):
        rest = side[i]
        for m in range(i):
            rest -= lower[i, m] * step[m]
        step[i] = rest / lower[i, i]
    for i in range(size - 1, -1, -1):
        rest = step[i]
        for m in range(i + 1, size):
            rest -= lower[m, i] * step[m]
        step[i] = rest / lower[i, i]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def inverted(matrix, inverse):  # type: ignore[no-untyped-def]
    """Whether ``matrix`` (n, n) is regular and positive; ``inverse`` (n, n) is then its inverse."""
    side = np.zeros(len(matrix))
    for i in range(side.size):
        side[i] = 1.0
        if not solved(matrix, side, inverse[i]):
            return False
        side[i] = 0.0
    return True
