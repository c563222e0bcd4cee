"""Errors that all frames of a video share: the change of their angles with one sigma of each."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array

_NOTHING = 0.01  # of the largest error


def one_sigma(covariance: Array) -> Array:
    """One sigma along each axis of the ellipse of a covariance (n, n), as columns (n, n)."""
    size, axes = np.linalg.eigh(covariance)
    return np.asarray(axes * np.sqrt(np.maximum(size, 0.0)))


def principal(errors: Array) -> Array:
    """Independent errors of the same covariance, the largest first, without negligible ones;
    (frames, errors) to (frames, fewer)."""
    left, size, _ = np.linalg.svd(errors, full_matrices=False)
    return np.asarray(left * size)[:, size > _NOTHING * size.max(initial=1e-12)]
