"""Frames of a track whose pictures repeat the ones before: their angles are not those of then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.tracking.core import Flag, Track
from servosight.tracking.uncertainty import lag_of_repeats


def with_repeats(track: Track) -> Track:
    """The track with these frames flagged, and by how much they lag behind in their sigma."""
    angle_deg = np.where(track.found, track.angle_deg, np.nan)
    lag_deg = lag_of_repeats(angle_deg, track.sigma_deg)
    late = lag_deg != 0.0
    if not late.any():
        return track
    count = np.count_nonzero(late)
    note = (
        f"{count} of {track.frames} pictures {'repeats' if count == 1 else 'repeat'} the one "
        f"before, where the angle lags behind by up to {np.abs(lag_deg).max():.2g} deg: sigma "
        "includes that"
    )
    return replace(
        track,
        sigma_deg=np.hypot(track.sigma_deg, lag_deg),
        flags=track.flags | np.where(late, Flag.DUPLICATE, Flag.NONE).astype(np.uint8),
        notes=(note, *track.notes),
    )
