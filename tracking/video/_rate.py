"""What presentation times say of the frame rate: even, or varying."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array

_OFF, _OFTEN = 0.1, 0.05  # of a frame time, and of the frames
_TICKS = 1.5  # in a frame's time, from which on a missing frame is more than rounding


def even_times(time_s: Array, tick_s: float) -> Array:
    """Presentation times without their rounding, where they are those of an even rate.

    A container that counts milliseconds shifts every frame by up to half of one: at 300 deg/s,
    0.15 deg. Where one line through all stamps explains them to within half a tick, they are
    that line, rounded; where none does (dropped frames, a free-running clock), they stay. So they
    do where the tick is about as long as a frame: a frame that is missing would pass for rounding.
    """
    number = np.arange(len(time_s))
    if len(time_s) < 3:
        return time_s
    slope, start = np.polyfit(number, time_s, 1)
    line = start + slope * number
    half = 0.5 * tick_s
    error = time_s - line
    if slope < _TICKS * tick_s or np.ptp(error) > 2.0 * half * 1.001 + 1e-9 or np.ptp(error) < 1e-9:
        return time_s
    return np.asarray(line + 0.5 * (error.max() + error.min()))


def varying_rate(step_s: Array, tick_s: float) -> list[str]:
    """A sentence where the times between frames (frames - 1,) vary by more than their rounding to
    ``tick_s``; single gaps are no varying rate.

    >>> varying_rate(np.full(60, 0.04), 0.001)
    []
    >>> varying_rate(np.resize([0.04, 0.08], 60), 0.001)[0]
    'the frame rate varies, mostly from 12.5 to 25 frames a second: each frame has its own time'
    """
    usual_s = float(np.median(step_s))
    if float(np.mean(np.abs(step_s - usual_s) > _OFF * usual_s + tick_s)) <= _OFTEN:
        return []
    short_s, long_s = np.quantile(step_s, [_OFTEN, 1.0 - _OFTEN])
    return [
        f"the frame rate varies, mostly from {1.0 / long_s:.3g} to {1.0 / short_s:.3g} frames a "
        "second: each frame has its own time"
    ]
