"""Regression on nuisance columns."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array


def projected_out(columns: Array, nuisance: Array) -> Array:
    """What is left of ``columns`` (samples, n) after regression on ``nuisance`` (samples, m)."""
    size = np.sqrt(np.einsum("ij,ij->j", nuisance, nuisance))
    seen = nuisance[:, size > 0.0] / size[size > 0.0]
    if seen.shape[1] == 0:
        return columns
    left, singular, _ = np.linalg.svd(seen, full_matrices=False)
    basis = left[:, singular > 1e-9 * singular[0]]
    return np.asarray(columns - basis @ (basis.T @ columns))
