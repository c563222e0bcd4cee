"""The sigma of a whole track, errors of its times included, and a note where it is large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.tracking.composite import TRUST, rough_note
from servosight.tracking.core import Track
from servosight.tracking.methods._time_error import with_time_error


def with_total_sigma(track: Track) -> Track:
    """The track with the error of its times in sigma, and a note where sigma, with all that it then
    holds, is large in degrees, however far the part turns.

    Noise, tilt and times may each be below that, and together above.
    """
    track = with_time_error(track)
    angle_deg, sigma_deg = track.angle_deg[track.found], track.sigma_deg[track.found]
    if sigma_deg.size == 0 or np.median(sigma_deg) <= TRUST.largest_sigma_deg:
        return track
    return replace(track, notes=(rough_note(angle_deg, sigma_deg), *track.notes))
