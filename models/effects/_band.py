"""A band of the drive that causes no torque: where a fit of its half width begins."""

from __future__ import annotations

from servosight.models.effects._contract import GuessFeatures


def band_starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Half of the residual, one and a half times and four times of it."""
    return tuple((share * features.residual_deg,) for share in (0.5, 1.5, 4.0))
