"""Frames of several recordings on one delay: when each one has them, with all else in common.

The times of a recording's frames are found by itself, where the dead time makes up for what they
are off. Recordings have the dead time in common, and differ in the times of their frames alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.identify.fit._frame_scene import CommandFrames, alone_in_frames, in_frames
from servosight.identify.fit._solution import Solution, polish
from servosight.identify.search import half_squares
from servosight.models.core import Recording

_ROUNDS = (0.25, 0.1, 0.04, 0.016)  # of a frame
_TRIED = 7  # times of the first frame, and of the last


def aligned(
    fit: Solution, recordings: Sequence[Recording], frames: Sequence[CommandFrames | None]
) -> tuple[tuple[CommandFrames | None, ...], Solution]:
    """The frames of ``recordings`` with times and lengths that suit one model, and that fit.

    ``fit`` is of the recordings in these ``frames``. One recording alone has nothing to agree with.
    """
    found = tuple(frames)
    if sum(one is not None for one in found) < 2:
        return found, fit
    for share in _ROUNDS:
        closer = tuple(
            one if one is None else _closest(fit, recordings[r], r, one, share)
            for r, one in enumerate(found)
        )
        problem = replace(fit.problem, recordings=in_frames(recordings, closer))
        better = polish(problem, [fit.outcome.point])
        if better.outcome.cost < fit.outcome.cost:
            found, fit = closer, better
    return found, fit


def _closest(
    fit: Solution, recording: Recording, r: int, frames: CommandFrames, share: float
) -> CommandFrames:
    """The frames with which the model as it is leaves least of one recording: the first and the
    last one up to a ``share`` of their length earlier or later."""
    first_s, last_s = recording.time_s[[0, -1]].tolist()
    count = (last_s - first_s) / frames.period_s
    to_first = round((first_s - frames.at_s) / frames.period_s)
    away_s = share * frames.period_s * np.linspace(-1.0, 1.0, _TRIED)
    tried = [
        CommandFrames(
            frames.period_s + (last - first) / count,
            frames.at_s + to_first * frames.period_s + first,
        )
        for first, last in itertools.product(away_s.tolist(), repeat=2)
    ]
    costs = [_cost(fit, recording, r, one) for one in tried]
    return tried[int(np.argmin(costs))]


def _cost(fit: Solution, recording: Recording, r: int, frames: CommandFrames) -> float:
    """Half the squared error of one recording with these frames, all parameters as fitted."""
    alone, point = alone_in_frames(fit, r, recording, frames)
    return float(half_squares(alone.residuals(point[None, :]))[0])
