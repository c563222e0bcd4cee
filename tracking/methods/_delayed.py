"""The error that all times of a track share where the exposure of its frames is not given.

It is no error of the angles frame by frame, so that what is asked of these is asked without it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.tracking.composite import TRUST
from servosight.tracking.core import Shutters, Track, principal
from servosight.tracking.uncertainty import by_delay

_MOST = 0.95  # of the frames


def late_deg(track: Track) -> float:
    """The error of angles [deg], one sigma, that the wrong time of a camera whose exposure is not
    given makes in most frames: at most that in 95 % of them."""
    if track.shutters is None or not track.found.any():
        return 0.0
    doubt_s = track.shutters.middle_doubt_s
    delay = by_delay(track.angle_deg, track.time_s, track.found, doubt_s)
    return float(np.quantile(np.abs(delay[track.found]), _MOST))


def with_delay(track: Track) -> Track:
    """The track with that error in its sigma, and beside the others that its frames share."""
    if track.shutters is None or track.shutters.middle_doubt_s == 0.0:
        return track
    delay = by_delay(track.angle_deg, track.time_s, track.found, track.shutters.middle_doubt_s)
    late = late_deg(track)
    if late > TRUST.largest_sigma_deg:
        track = replace(track, notes=(*track.notes, _uncertain(late, track.shutters)))
    known = [] if track.shared_deg is None else [track.shared_deg]
    sigma_deg = np.hypot(track.sigma_deg, delay[:, 0])
    return replace(track, sigma_deg=sigma_deg, shared_deg=principal(np.hstack([*known, delay])))


def _uncertain(late: float, shutters: Shutters) -> str:
    return (
        f"all times may be off by {1e3 * shutters.middle_doubt_s:.2g} ms (one sigma), the same in "
        f"all frames, which in the fastest is {late:.2g} deg: give the exposure where that is too "
        "much"
    )
