"""The sigma of a whole track, errors of its times included, and a note where it is large."""

from __future__ import annotations

from dataclasses import replace

from servosight.tracking.composite import rough_note, uncertain
from servosight.tracking.core import Track
from servosight.tracking.methods._time_error import with_time_error


def with_total_sigma(track: Track) -> Track:
    """The track with the error of its times in sigma, and a note where sigma, with all that it then
    holds, is larger than that of a track which needs none.

    Noise, tilt and times may each be below that, and together above.
    """
    track = with_time_error(track)
    angle_deg, sigma_deg = track.angle_deg[track.found], track.sigma_deg[track.found]
    if sigma_deg.size == 0 or uncertain(angle_deg, sigma_deg) is None:
        return track
    return replace(track, notes=(rough_note(angle_deg, sigma_deg), *track.notes))
