"""First guess of what a recording has for itself: the angle's zero, the motion at its start."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Mask, Recording

_FIRST = 3
"""Samples whose mean is the first angle."""


def own_start(recording: Recording, gain: float, mask: Mask | None = None) -> Array:
    """Bias [deg], initial angle [deg] and initial speed [deg/s], (3,), for a fit to begin at.

    The bias is what a servo of static gain ``gain`` has on the median of the angle; the initial
    angle is the mean of the first samples. Only samples under ``mask`` count; by default all.

    >>> import numpy as np
    >>> time_s = np.arange(5.0)
    >>> held = Recording("held", time_s, np.full(5, 10.0), time_s, np.full(5, 9.0))
    >>> own_start(held, gain=0.8).tolist()
    [1.0, 9.0, 0.0]
    """
    angle = recording.angle_deg if mask is None else recording.angle_deg[mask]
    bias = np.median(angle) - gain * np.median(recording.command_deg)
    return np.array([bias, angle[:_FIRST].mean(), 0.0])


def own_starts(recording: Recording, gain: float, mask: Mask | None = None) -> Array:
    """The same and two guesses with another bias, (3, 3): that on the first samples, and none.

    Friction and weight keep the median angle from where the gain alone has it by far more than the
    bias is, a moment at rest less, and a sensor in the loop has none.

    >>> import numpy as np
    >>> time_s = np.arange(5.0)
    >>> angle = np.array([8.5, 8.5, 8.5, 7.0, 7.0])
    >>> moved = Recording("moved", time_s, np.array([10.0, 10.0, 10.0, 8.0, 8.0]), time_s, angle)
    >>> own_starts(moved, gain=0.8).tolist()
    [[0.5, 8.5, 0.0], [0.5, 8.5, 0.0], [0.0, 8.5, 0.0]]
    """
    own = own_start(recording, gain, mask)
    time_s = recording.time_s if mask is None else recording.time_s[mask]
    first = own[1] - gain * recording.command_at(time_s[:_FIRST]).mean()
    return np.array([[bias, *own[1:]] for bias in (own[0], first, 0.0)])
