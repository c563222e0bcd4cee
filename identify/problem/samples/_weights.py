"""How much each sample counts in a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Recording

TOLERANCE_SHARE = 5e-4
"""Default tolerance as a share of the moved range: no model is right to the last digit."""


def sample_weights(recordings: Sequence[Recording]) -> tuple[Array, ...]:
    """For each recording its samples' weights, (samples,): ones where no sigma is known.

    A sample counts by rms(sigma) / sigma within its recording, and recordings among themselves
    by their rms sigma together with the tolerance: a horn that is measured less accurately than
    the surface must not make the parameters that the surface determines less accurate.
    """
    within = tuple(_weights(recording) for recording in recordings)
    sizes = np.array([_size_deg(recording) for recording in recordings])
    if not np.all(sizes > 0.0):
        return within
    among = np.sqrt(np.mean(sizes**2)) / sizes
    return tuple(weight * share for weight, share in zip(within, among, strict=True))


def _size_deg(recording: Recording) -> float:
    """hypot(rms sigma, tolerance) [deg]; 0 where no sigma is known."""
    sigma = recording.sigma_deg
    if sigma is None or not np.all(sigma > 0.0):
        return 0.0
    tolerance = TOLERANCE_SHARE * recording.moved_range_deg
    return float(np.sqrt(np.mean(sigma**2) + tolerance**2))


def _weights(recording: Recording) -> Array:
    sigma = recording.sigma_deg
    if sigma is None or not np.all(sigma > 0.0):
        return np.ones(recording.time_s.size)
    return np.asarray(np.sqrt(np.mean(sigma**2)) / sigma)
