"""A command that brings a servo from where it stands to where a run starts."""

from __future__ import annotations

import math

import numpy as np

from servosight.bench.safety._limits import Limits
from servosight.models.core import Array

PERIOD_S = 0.02
"""Time between rows of a ramp: the pulse period of a hobby servo."""


def ramp(limits: Limits, from_deg: float, to_deg: float) -> tuple[Array, Array]:
    """Rows (time_s, angle_deg) of a smooth move, (rows,) each, within rate and acceleration.

    The angle follows ``s - sin(2 pi s) / (2 pi)`` over ``s`` from 0 to 1: speed and acceleration
    begin and end at zero, the largest speed is twice the mean, the largest acceleration
    ``2 pi`` distance / duration^2. The last row is ``to_deg``. ``from_deg`` may lie outside the
    range, since a servo without torque stands anywhere.

    >>> time_s, angle_deg = ramp(Limits(ramp_deg_s=30.0), 0.0, 30.0)
    >>> float(time_s[-1]), float(angle_deg[-1])
    (2.0, 30.0)
    """
    distance = abs(to_deg - from_deg)
    duration = 2.0 * distance / limits.ramp_rate_deg_s
    if limits.acceleration_deg_s2 is not None:
        duration = max(duration, math.sqrt(2.0 * math.pi * distance / limits.acceleration_deg_s2))
    steps = max(1, math.ceil(duration / PERIOD_S))
    rows = np.arange(steps + 1, dtype=np.float64)
    share = rows / steps
    smooth = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)
    angle: Array = from_deg + (to_deg - from_deg) * smooth
    angle[-1] = to_deg
    return PERIOD_S * rows, angle
