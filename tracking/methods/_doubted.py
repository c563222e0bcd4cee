"""A track says so where its angles are uncertain as a whole, by whatever its sigma holds."""

from __future__ import annotations

from dataclasses import replace

from servosight.tracking.composite import rough_note, uncertain
from servosight.tracking.core import Track
from servosight.tracking.methods._delayed import with_delay


def with_doubts(track: Track) -> Track:
    """The track with the error of its times in sigma, and a note where sigma, with all that it then
    holds, is larger than that of a track which needs none.

    Noise, tilt and times may each be below that, and together above.
    """
    track = with_delay(track)
    angle_deg, sigma_deg = track.angle_deg[track.found], track.sigma_deg[track.found]
    if sigma_deg.size == 0 or uncertain(angle_deg, sigma_deg) is None:
        return track
    return replace(track, notes=(rough_note(angle_deg, sigma_deg), *track.notes))
