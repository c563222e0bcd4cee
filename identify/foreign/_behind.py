"""What lies behind the output of an FMU: the instants at which it turns round, and the sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array
from servosight.models.effects import Effect

_TINY_S = 1e-12


def with_turns(time_s: Array, angle_deg: Array) -> tuple[Array, Array]:
    """The motion with the instants between its samples at which it turns round, by parabolas.

    What remembers the last turn, as play does, must see how far the motion went.
    """
    change = np.diff(angle_deg)
    turns = np.flatnonzero(change[:-1] * change[1:] < 0.0) + 1
    if not turns.size:
        return time_s, angle_deg
    before, behind = time_s[turns] - time_s[turns - 1], time_s[turns + 1] - time_s[turns]
    left, right = change[turns - 1] / before, change[turns] / behind
    bend = (right - left) / (before + behind)
    slope = (left * behind + right * before) / (before + behind)
    shift = -slope / (2.0 * bend)
    seen = np.abs(shift) > _TINY_S
    at = (time_s[turns] + shift)[seen]
    angle = (angle_deg[turns] + 0.5 * slope * shift)[seen]
    place = np.searchsorted(time_s, at)
    return np.insert(time_s, place, at), np.insert(angle_deg, place, angle)


def measured(effects: Sequence[tuple[Effect, tuple[float, ...]]], angle_deg: Array) -> Array:
    """What sensors with these values make of an angle, (instants,), one behind the other."""
    for sensor, values in effects:
        pairs = zip(sensor.parameters, values, strict=True)
        if any(q.neutral is not None and value != q.neutral for q, value in pairs):
            assert sensor.term is not None
            angle_deg = np.array([sensor.term(angle, *values) for angle in angle_deg.tolist()])
    return angle_deg
