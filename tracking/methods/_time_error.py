"""The error that all times of a track share where the exposure of its frames is not given.

It is no error of the angles frame by frame, so that what is asked of these is asked without it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.core import Array, rms
from servosight.tracking.composite import TRUST
from servosight.tracking.core import Shutters, Track, principal
from servosight.tracking.uncertainty import by_delay

_MOST = 0.95  # of the frames


def late_rms_deg(track: Track) -> float:
    """The rms error of angles [deg], one sigma, that the wrong time of a camera whose exposure is
    not given makes."""
    if track.shutters is None or not track.found.any():
        return 0.0
    return rms(_delay(track, track.shutters)[track.found])


def with_time_error(track: Track) -> Track:
    """The track with that error in its sigma, and beside the others that its frames share."""
    if track.shutters is None or track.shutters.middle_doubt_s == 0.0:
        return track
    delay = _delay(track, track.shutters)
    late = _late(track, delay)
    if late > TRUST.largest_sigma_deg:
        track = replace(track, notes=(*track.notes, _uncertain(late, track.shutters)))
    known = [] if track.shared_deg is None else [track.shared_deg]
    sigma_deg = np.hypot(track.sigma_deg, delay[:, 0])
    return replace(track, sigma_deg=sigma_deg, shared_deg=principal(np.hstack([*known, delay])))


def _delay(track: Track, shutters: Shutters) -> Array:
    return by_delay(track.angle_deg, track.time_s, track.found, shutters.middle_doubt_s)


def _late(track: Track, delay: Array) -> float:
    """The error of angles [deg], one sigma, that a wrong time makes in 95 % of the frames at
    most."""
    found = np.abs(delay[track.found])
    return float(np.quantile(found, _MOST)) if found.size else 0.0


def _uncertain(late: float, shutters: Shutters) -> str:
    return (
        f"all times may be off by {1e3 * shutters.middle_doubt_s:.2g} ms (one sigma), the same in "
        f"all frames, which in the fastest is {late:.2g} deg: give the exposure where that is too "
        "much"
    )
