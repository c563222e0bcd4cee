"""Samples that repeat an old value: a bus that returns it once more, a sensor slower than the log.

Either way the value is that of the sample before, exactly, while the servo moves. A servo that
sticks repeats its angle, too; how the two are distinguished is in :class:`ReadErrorLimits`.
"""

from __future__ import annotations

import numpy as np

from servosight.identify.problem.noise import resolution_deg
from servosight.identify.problem.samples._read_limits import LIMITS, ReadErrorLimits
from servosight.models.core import Array, Mask, Recording, runs_of

_BESIDE = 2
"""Moves on either side of an old value that say how fast the servo is."""


def old_values(recording: Recording, limits: ReadErrorLimits = LIMITS) -> Mask:
    """Which samples are the one before read again while the servo moves, (samples,).

    >>> time_s = np.arange(0.0, 2.0, 0.01)
    >>> angle_deg = 10.0 * np.sin(5.0 * time_s)
    >>> angle_deg[130] = angle_deg[129]
    >>> log = Recording.from_arrays(time_s=time_s, angle_deg=angle_deg, command_deg=np.sin(time_s))
    >>> np.flatnonzero(old_values(log)).tolist()
    [130]
    """
    time_s, angle = recording.time_s, recording.angle_deg
    old = np.zeros(angle.size, dtype=bool)
    change = np.diff(angle, prepend=np.inf)
    starts, ends = runs_of(change == 0.0).T
    least = limits.moving_steps * max(resolution_deg(angle), 1e-9)
    fits = (starts > _BESIDE) & (ends + _BESIDE < angle.size) & (ends - starts <= limits.longest)
    moving = np.abs(change[starts - 1]) >= least  # most runs are at rest
    for first, next_ in zip(starts[fits & moving], ends[fits & moving], strict=True):
        last = next_ + _BESIDE + 1
        beside = slice(first - 1 - _BESIDE, first), slice(next_, last)
        moves = np.concatenate([np.diff(angle[part]) for part in beside])
        took = np.concatenate([np.diff(time_s[part]) for part in beside])
        across = (angle[next_] - angle[first - 1]) / (time_s[next_] - time_s[first - 1])
        speeds = moves / took
        if np.any(np.abs(moves) < least) or np.any(speeds * across <= 0.0):
            continue
        if _catches_up(np.abs(speeds), abs(across), limits):
            old[first:next_] = True
    return old


def _catches_up(speeds: Array, across: float, limits: ReadErrorLimits) -> bool:
    """Whether the mean speed across an old value is what those beside it, in order, make of it.

    Speeds alike beside it make their mean. Where the servo brakes or gathers speed, only the two
    nearest say how fast it is there: a servo that sticks would have to brake and start within it,
    and come out of it at another speed than one that has braked or gathered speed all the time.
    """
    if np.max(speeds) <= limits.alike * np.min(speeds):
        expected = float(np.mean(speeds))
    else:
        change = np.diff(np.insert(speeds, _BESIDE, across))
        if not (np.all(change >= 0.0) or np.all(change <= 0.0)):
            return False
        expected = float(np.mean(speeds[_BESIDE - 1 : _BESIDE + 1]))
    return 1.0 / limits.made_up <= across / expected <= limits.made_up


def held_values(recording: Recording, limits: ReadErrorLimits = LIMITS) -> Mask:
    """Which samples only repeat the one before, as the sensor is slower than the log, (samples,).

    None where that is not plain: see :class:`ReadErrorLimits`.

    >>> time_s = np.arange(0.0, 2.0, 0.01)
    >>> angle_deg = np.repeat(10.0 * np.sin(5.0 * time_s[::2]), 2)
    >>> log = Recording.from_arrays(time_s=time_s, angle_deg=angle_deg, command_deg=np.sin(time_s))
    >>> np.flatnonzero(held_values(log)).tolist()[:3]
    [3, 5, 7]
    """
    time_s, angle = recording.time_s, recording.angle_deg
    none = np.zeros(angle.size, dtype=bool)
    repeats = np.diff(angle, prepend=np.inf) == 0.0
    starts = np.flatnonzero(~repeats)
    if starts.size < limits.held_runs:
        return none
    moves, lengths = np.diff(angle[starts]), np.diff(starts)
    fast = np.abs(moves) >= limits.moving_steps * max(resolution_deg(angle), 1e-9)
    # Moving before and behind, in one direction: at rest and at reversals all runs are long.
    moving = np.zeros(starts.size, dtype=bool)
    moving[1:-1] = fast[:-1] & fast[1:] & (moves[:-1] * moves[1:] > 0.0)
    if moving.sum() < limits.held_runs:
        return none
    # How far the servo gets from one update to the next; the log's stamps are not the sensor's.
    length, way = lengths[moving[:-1]], np.abs(moves)[moving[:-1]]
    shortest = int(length.min())
    regular = (length == shortest) | (length == shortest + 1)
    ends = np.quantile(way, (0.1, 0.9))
    if (
        shortest > limits.longest
        or np.mean(regular) < limits.held_alike
        or np.mean(length > 1) < limits.held_share
        or ends[1] < limits.held_speeds * ends[0]
    ):
        return none
    kinds = [way[length == one] for one in (shortest, shortest + 1)]
    if all(kind.size >= limits.held_runs / 4 for kind in kinds):
        low, high = sorted(float(np.median(kind)) for kind in kinds)
        if high > limits.made_up * low:  # the slower it moves the longer it rests: it sticks
            return none
    changes = np.cumsum(np.diff(recording.command_at(time_s), prepend=np.inf) != 0.0)
    several = np.flatnonzero(moving[:-1] & (lengths > 1))
    inside = changes[starts[several + 1] - 1] - changes[starts[several]]
    before = changes[starts[several]] - changes[starts[several - 1]]
    if np.mean((inside > 0) | (before == 0)) < limits.held_alike:
        return none  # a servo that follows a staircase
    held: Mask = repeats & moving[np.cumsum(~repeats) - 1]
    return held
