"""Covariance of a fit by what differs from sample to sample: noise, and the model's own error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.identify.uncertainty._correlation import weighted_normal
from servosight.identify.uncertainty._misfit import misfit_covariance
from servosight.models.core import Array, Mask


def sampling_covariance(
    jacobians: Sequence[Array],
    residuals: Sequence[Array],
    masks: Sequence[Mask],
    times_s: Sequence[Array],
    inverse: Array,
    misfit: float,
    fitted: int,
) -> Array:
    """(known, known) of the determined coordinates, from each recording's Jacobian and residuals.

    The sandwich (J'J)^-1 J'RJ (J'J)^-1 with R the covariance of the residuals over time (White,
    Econometrica 50 (1982); Seber and Wild, Nonlinear Regression, 1989, section 6.2); where they
    are white it is s^2 (J'J)^-1, s^2 with the degrees of freedom that ``fitted`` coordinates
    leave. ``inverse`` is (J'J)^-1. To the extent ``misfit``, 0 to 1, that
    the residuals are the model's own error, :func:`misfit_covariance` takes its place.
    """
    parts = zip(jacobians, residuals, masks, strict=True)
    meat = sum((weighted_normal(*one) for one in parts), np.zeros(inverse.shape))
    samples = sum(int(mask.sum()) for mask in masks)
    found = np.asarray(inverse @ meat @ inverse) * (samples / max(samples - fitted, 1))
    if misfit > 0.0 and inverse.size:
        own = misfit_covariance(jacobians, residuals, masks, times_s, inverse)
        found = (1.0 - misfit) * found + misfit * own
    return found
