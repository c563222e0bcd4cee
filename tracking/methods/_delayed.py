"""The error that all times of a track share where the exposure of its frames is not given.

It is no error of the angles frame by frame, so that what is asked of these is asked without it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.tracking.core import Track, principal
from servosight.tracking.uncertainty import by_delay


def with_delay(track: Track) -> Track:
    """The track with that error in its sigma, and beside the others that its frames share."""
    if track.shutters is None or track.shutters.middle_doubt_s == 0.0:
        return track
    delay = by_delay(track.angle_deg, track.time_s, track.found, track.shutters.middle_doubt_s)
    known = [] if track.shared_deg is None else [track.shared_deg]
    sigma_deg = np.hypot(track.sigma_deg, delay[:, 0])
    return replace(track, sigma_deg=sigma_deg, shared_deg=principal(np.hstack([*known, delay])))
