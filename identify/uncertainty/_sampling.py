"""Covariance of a fit by what differs from sample to sample: noise, and the model's own error.

The model's own error depends on the motion and is large in some parts of a recording. Two estimates
of what it does to the parameters, each right where the other is not; the larger counts.

- :func:`stationary_covariance`, right where error and motion are stationary.
- The jackknife over blocks of time (:class:`BlockMoves`), right where the error grows with motion.

Both are linear: nothing is fitted anew.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.identify.uncertainty._blocks import block_moves
from servosight.identify.uncertainty._correlation import weighted_normal
from servosight.identify.uncertainty._stationary import stationary_covariance
from servosight.models.core import Array, Mask

_WHOLE = 0.25
"""A scatter of blocks beyond chance by this share is all the model's own error."""
_NOISY = 1.1
"""Residuals above the noise by no more than this factor are taken for noise."""


def misfit_share(mean_square_deg2: float, noise_deg: float) -> float:
    """Share of the mean squared residual that the noise of the measurement does not account for.

    0 where it is within 10 % of the noise, which is not known to more.

    >>> misfit_share(0.01, 0.1)
    0.0
    >>> round(misfit_share(0.0484, 0.1), 2)
    0.75
    """
    if mean_square_deg2 <= 0.0:
        return 0.0
    return max(1.0 - (_NOISY * noise_deg) ** 2 / mean_square_deg2, 0.0)


def sampling_covariance(
    jacobians: Sequence[Array],
    residuals: Sequence[Array],
    masks: Sequence[Mask],
    times_s: Sequence[Array],
    inverse: Array,
    shared: Mask,
    misfit: float,
    fitted: int,
) -> Array:
    """(known, known) of the determined coordinates, from each recording's Jacobian and residuals.

    The sandwich (J'J)^-1 J'RJ (J'J)^-1 with R the covariance of the residuals over time (White,
    Econometrica 50 (1982); Seber and Wild, Nonlinear Regression, 1989, section 6.2); where they
    are white it is s^2 (J'J)^-1, s^2 with the degrees of freedom that ``fitted`` coordinates
    leave. ``inverse`` is (J'J)^-1.

    An error of the model takes its place to the extent ``misfit``, 0 to 1, that the residuals
    exceed the noise, or that the ``shared`` coordinates (known,) scatter from block to block more
    than the sandwich and chance have it: an error that stays below the noise of a sample shows
    there alone, and many samples do not average it out.
    """
    parts = zip(jacobians, residuals, masks, strict=True)
    meat = sum((weighted_normal(*one) for one in parts), np.zeros(inverse.shape))
    samples = sum(int(mask.sum()) for mask in masks)
    noise = np.asarray(inverse @ meat @ inverse) * (samples / max(samples - fitted, 1))
    if not inverse.size:
        return noise
    blocks = block_moves(jacobians, residuals, times_s, inverse)
    excess = max(blocks.excess(noise, inverse, shared), 1.0)
    beyond = excess / blocks.by_chance(shared) - 1.0
    extent = max(misfit, min(beyond / _WHOLE, 1.0))
    if extent <= 0.0:
        return noise
    least = blocks.variances(excess * np.diag(noise))
    own = _widened(stationary_covariance(jacobians, residuals, masks, inverse), least)
    return _widened((1.0 - extent) * noise + extent * own, np.diag(noise))


def _widened(covariance: Array, least: Array) -> Array:
    """A covariance with no variance below ``least``, and its own correlations."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(least / np.diag(covariance))
    wider = np.where(ratio > 1.0, ratio, 1.0)
    return np.asarray(covariance * np.outer(wider, wider))
