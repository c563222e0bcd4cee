"""A band of the drive that causes no torque: where a fit of its half width begins."""

from __future__ import annotations

from servosight.models.effects._contract import GuessFeatures


def band_starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Half of the residual to ten times of it: friction in the model takes most of what a wide band
    does for its own."""
    return tuple((share * features.residual_deg,) for share in (0.5, 1.5, 4.0, 10.0))
