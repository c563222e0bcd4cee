"""Where a model fails: the time windows that hold most of the error, and what went on there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.diagnose.residuals._judged import Judged
from servosight.models.core import Array

WINDOW_S = 0.3
STEP_SHARE = 0.08
FAST_SHARE = 0.35
SLOW_SHARE = 0.03
HIGH_FREQUENCY_HZ = 4.0


@dataclass(frozen=True, kw_only=True)
class Window:
    """A stretch of time with its rms error, its share of the whole squared error, and a name.

    ``what`` is one of reversal, standstill, slew, step, high_frequency.
    """

    recording: str
    start_s: float
    end_s: float
    rmse_deg: float
    share: float
    what: str


@dataclass(frozen=True)
class MotionSamples:
    """What the servo was doing: speed by the model's prediction, and the command at each sample."""

    speed_deg_s: Array
    command_deg: Array
    jump_deg: Array
    turns_hz: Array

    @classmethod
    def of(cls, judged: Judged) -> MotionSamples:
        """Read the motion off a prediction and its command."""
        recording = judged.recording
        command = recording.command_at(recording.time_s)
        return cls(
            np.gradient(judged.predicted_deg, recording.time_s),
            command,
            _largest_jump(judged),
            _turning_rate(recording.time_s, command),
        )


def worst_windows(judged: Sequence[Judged], count: int = 6) -> list[Window]:
    """The windows with the largest share of the squared error, largest first."""
    total = sum(float(np.sum(one.error_deg**2)) for one in judged)
    found = [window for one in judged for window in _windows(one, total, count)]
    return sorted(found, key=lambda window: window.share, reverse=True)[:count]


def shares(judged: Sequence[Judged]) -> dict[str, float]:
    """Share of the squared error in each kind of motion, over whole recordings."""
    total = max(sum(float(np.sum(one.error_deg**2)) for one in judged), 1e-300)
    table: dict[str, float] = {}
    for one in judged:
        kinds = classify(MotionSamples.of(one), one.recording.time_s)
        for kind in np.unique(kinds):
            part = float(np.sum(one.error_deg[kinds == kind] ** 2)) / total
            table[str(kind)] = table.get(str(kind), 0.0) + part
    return dict(sorted(table.items(), key=lambda item: -item[1]))


def classify(motion: MotionSamples, time_s: Array) -> NDArray[np.str_]:
    """What the servo was doing at each sample."""
    fastest = float(np.quantile(np.abs(motion.speed_deg_s), 0.98)) or 1.0
    span = float(np.ptp(motion.command_deg)) or 1.0
    speed = np.abs(motion.speed_deg_s)
    kinds = np.full(time_s.size, "slew", dtype="<U14")
    kinds[speed < FAST_SHARE * fastest] = "reversal"
    moving = _near(speed > SLOW_SHARE * fastest, time_s, 0.1)
    turning = _near(
        np.concatenate([[False], np.diff(np.sign(motion.speed_deg_s)) != 0]), time_s, 0.08
    )
    kinds[(speed < FAST_SHARE * fastest) & ~turning] = "slew"
    kinds[turning & moving] = "reversal"
    kinds[motion.turns_hz > 2.0 * HIGH_FREQUENCY_HZ] = "high_frequency"
    kinds[~moving] = "standstill"
    kinds[motion.jump_deg > STEP_SHARE * span] = "step"
    return kinds


def _windows(one: Judged, total: float, count: int) -> list[Window]:
    time_s = one.recording.time_s
    square = one.error_deg**2
    kinds = classify(MotionSamples.of(one), time_s)
    gathered = np.concatenate([[0.0], np.cumsum(square)])
    ends = np.searchsorted(time_s, time_s + WINDOW_S, side="right")
    sums = gathered[ends] - gathered[:-1]
    taken = np.zeros(time_s.size, dtype=bool)
    found = []
    for start in np.argsort(sums)[::-1]:
        stop = int(ends[start])
        if taken[start:stop].any() or sums[start] <= 0.0:
            continue
        taken[start:stop] = True
        weight = {
            str(kind): float(square[start:stop][kinds[start:stop] == kind].sum())
            for kind in np.unique(kinds[start:stop])
        }
        found.append(
            Window(
                recording=one.recording.name,
                start_s=float(time_s[start]),
                end_s=float(time_s[stop - 1]),
                rmse_deg=float(np.sqrt(sums[start] / (stop - start))),
                share=float(sums[start] / max(total, 1e-300)),
                what=max(weight, key=lambda kind: weight[kind]),
            )
        )
        if len(found) == count:
            break
    return found


def _largest_jump(judged: Judged) -> Array:
    """Largest jump of a held command in the last 0.25 s before each sample [deg]."""
    recording = judged.recording
    if recording.hold == "linear" or recording.command_deg.size < 2:
        return np.zeros(recording.time_s.size)
    jumps = np.abs(np.diff(recording.command_deg))
    # What the command usually changes by from sample to sample; nothing where it is mostly held.
    steps = np.diff(recording.command_at(recording.time_s))
    usual = 4.0 * float(np.quantile(np.abs(steps), 0.9))
    times = recording.command_time_s[1:]
    out = np.zeros(recording.time_s.size)
    for when, size in zip(times[jumps > usual], jumps[jumps > usual], strict=True):
        inside = (recording.time_s >= when) & (recording.time_s < when + 0.25)
        out[inside] = np.maximum(out[inside], size)
    return out


def _turning_rate(time_s: Array, command_deg: Array) -> Array:
    """How often the command turns round about each sample [turns a second], over half a second."""
    slope = np.diff(command_deg)
    moving = np.flatnonzero(slope)
    turns = np.zeros(time_s.size)
    if moving.size > 1:
        flips = moving[1:][np.diff(np.sign(slope[moving])) != 0]
        turns[flips] = 1.0
    gathered = np.concatenate([[0.0], np.cumsum(turns)])
    after = np.searchsorted(time_s, time_s + 0.25, side="right")
    before = np.searchsorted(time_s, time_s - 0.25, side="left")
    return np.asarray((gathered[after] - gathered[before]) / 0.5)


def _near(marks: NDArray[np.bool_], time_s: Array, reach_s: float) -> NDArray[np.bool_]:
    """True within ``reach_s`` of a mark."""
    gathered = np.concatenate([[0], np.cumsum(marks)])
    after = np.searchsorted(time_s, time_s + reach_s, side="right")
    before = np.searchsorted(time_s, time_s - reach_s, side="left")
    return np.asarray(gathered[after] > gathered[before])
