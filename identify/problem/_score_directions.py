"""What a change of the prediction could take off a model's error, without a fit."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array

_NOTHING = 1e-6
"""A change this small beside the residual is rounding, whatever its direction."""


def directions(changes: Array, residual: Array, jacobian: Array) -> tuple[Array, Array]:
    """Unit directions (changes, samples) of changes of the residual, and how far each leads.

    ``changes`` (changes, samples) are residuals with something new minus ``residual`` (samples,)
    without it, whose ``jacobian`` (samples, parameters) takes out what the model's own parameters
    can do for themselves. The second answer (changes,) is the root of the sum of squares that each
    takes off when it is scaled at will; negative where it leads away; 0 where it changes nothing.
    """
    basis, _ = np.linalg.qr(jacobian)
    left = residual - basis @ (basis.T @ residual)
    own = changes - (changes @ basis) @ basis.T
    size = np.linalg.norm(own, axis=1)
    dead = size <= _NOTHING * np.linalg.norm(residual)
    unit = np.where(dead[:, None], 0.0, -own / np.where(dead, 1.0, size)[:, None])
    return unit, unit @ left
