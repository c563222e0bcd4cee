"""What a frame's time stamp means, and even times from stamps that jitter."""

from __future__ import annotations

from typing import Literal

import numpy as np

from servosight.models.core import Array

Meaning = Literal["exposure_start", "frame_end", "arrival"]
"""Start of the first row's exposure; end of the last row's readout; receipt by the host."""

MEANINGS: dict[Meaning, str] = {
    "exposure_start": "the start of the first row's exposure",
    "frame_end": "the end of the last row's readout",
    "arrival": "the frame's receipt by this computer, later by a latency that is not known",
}

_LATE = 0.35  # share of a frame time, rms, beyond which stamps follow no even rate
_ROUNDS = 4


def mid_exposure(
    stamps_s: Array, meaning: Meaning, exposure_s: float, readout_s: float = 0.0
) -> Array:
    """Mid-exposure times of the middle row [s] from stamps (frames,), on the camera's own clock.

    An arrival is taken for the end of the frame: the latency remains in it.

    >>> mid_exposure(np.array([1.0]), "frame_end", 0.004, 0.01).round(4).tolist()
    [0.993]
    """
    half = 0.5 * (exposure_s + readout_s)
    return stamps_s + half if meaning == "exposure_start" else stamps_s - half


def lost_between(numbers: Array) -> int:
    """How many frames a camera that numbers them took and did not deliver.

    >>> lost_between(np.array([4.0, 5.0, 8.0]))
    2
    """
    return max(int(numbers[-1] - numbers[0]) + 1 - len(numbers), 0) if len(numbers) else 0


def even_stamps(stamps_s: Array) -> Array:
    """Stamps without the jitter of their delivery, where one even rate explains them.

    A free-running camera takes frames at the rate of its own oscillator; the network or the
    operating system delivers them with jitter, and loses some. Each stamp gets the nearest number
    of an even rate, and is replaced by the line through all of them. Stamps that follow no even
    rate come back as they are.

    >>> taken_s = np.arange(200) / 60
    >>> late_s = taken_s + np.random.default_rng(1).uniform(0.0, 0.004, 200)
    >>> bool(np.ptp(even_stamps(late_s) - taken_s) < 1e-3)
    True
    """
    if stamps_s.size < 10:
        return stamps_s
    period = float(np.median(np.diff(stamps_s)))
    start = float(stamps_s[0])
    number = np.zeros(stamps_s.size)
    for _ in range(_ROUNDS):
        # Counted along the way: an error of the first period would add up over a long recording.
        steps = np.maximum(np.rint(np.diff(stamps_s) / period), 0.0)
        number = np.concatenate([[0.0], np.cumsum(steps)])
        period, start = (float(x) for x in np.polyfit(number, stamps_s, 1))
    line = start + period * number
    off = np.sqrt(np.mean((stamps_s - line) ** 2))
    if off > _LATE * period or (np.diff(number) < 1.0).any():
        return stamps_s
    return np.asarray(line)
