"""Score directions: by how much a change of the prediction could lower a model's error, to first
order and without a fit."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array

_NEGLIGIBLE = 1e-6
"""A change this small beside the residual is rounding, whatever its direction."""


def score_directions(changes: Array, residual: Array, jacobian: Array) -> tuple[Array, Array]:
    """Unit directions (changes, samples) of changes of the residual, and the gain of each.

    ``changes`` (changes, samples) are residuals with something new minus ``residual`` (samples,)
    without it. What the model's own parameters could do, the columns of ``jacobian`` (samples,
    parameters), is projected out of both. The gain (changes,) is the root of the sum of squares
    that a change removes when it is scaled freely; negative where only its opposite would; 0 where
    it changes nothing.
    """
    basis, _ = np.linalg.qr(jacobian[:, np.any(jacobian, axis=0)])  # a held one does nothing
    left = residual - basis @ (basis.T @ residual)
    own = changes - (changes @ basis) @ basis.T
    size = np.linalg.norm(own, axis=1)
    dead = size <= _NEGLIGIBLE * np.linalg.norm(residual)
    unit = np.where(dead[:, None], 0.0, -own / np.where(dead, 1.0, size)[:, None])
    return unit, unit @ left
