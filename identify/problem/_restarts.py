"""Where a prediction over a horizon begins anew, and with which measured motion.

The error of a simulation through a whole recording has many minima where friction, play and limits
act: a surface that sticks too early stays wrong for seconds. Over a few time constants, from the
measured motion on, it has few; and the parameters of the least error are nearly the same.
Multiple shooting: Bock and Plitt, IFAC World Congress (1984); here the states are not fitted.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Mask, Recording

SMOOTHED_S = 0.02
"""Angle and speed come from a parabola through the samples within this time on either side."""
FEWEST = 3
"""Number of samples on either side that the parabola takes where that time has fewer."""


def restarts(recording: Recording, scored: Mask, horizon_s: float) -> Array:
    """Times [s], angles [deg] and speeds [deg/s] each ``horizon_s``, (3, restarts).

    Only ``scored`` samples tell of the motion. None stands where samples are so rare or so many are
    not scored that a parabola would be as long as the horizon.
    """
    time, angle = recording.time_s, recording.angle_deg
    found = []
    for at in np.searchsorted(time, np.arange(time[0] + horizon_s, time[-1], horizon_s)):
        near = _near(time, int(at))
        if scored[near].all() and np.ptp(time[near]) <= horizon_s:
            _, slope, level = np.polyfit(time[near] - time[at], angle[near], 2)
            found.append((time[at], level, slope))
    return np.array(found).reshape(-1, 3).T


def _near(time: Array, at: int) -> slice:
    """The samples of the parabola about one of them."""
    first, last = np.searchsorted(time, [time[at] - SMOOTHED_S, time[at] + SMOOTHED_S])
    first, last = min(int(first), at - FEWEST), max(int(last), at + FEWEST + 1)
    return slice(max(first, 0), min(last, time.size))
