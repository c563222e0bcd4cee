"""A part that turns on and on beside another one: a fan, a wheel that is driven, not a servo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.core import Array, FrameProgress
from servosight.tracking.core import Track, TrackOptions, TrackRefused
from servosight.tracking.methods._contract import Method
from servosight.tracking.video import Film

_LEAST_DEG = 720.0
_UNEVEN = 0.3  # of the median step from frame to frame, in nine of ten frames


def turns_evenly(angle_deg: Array) -> bool:
    """Whether angles (frames,) of a part go round twice and more, at a speed that hardly changes.

    >>> import numpy as np
    >>> turns_evenly(np.linspace(0.0, 1000.0, 90))
    True
    >>> turns_evenly(500.0 * np.sin(np.linspace(0.0, 6.0, 90)))
    False
    """
    steps = np.diff(angle_deg)
    if steps.size == 0 or np.ptp(angle_deg) < _LEAST_DEG:
        return False
    low, middle, high = np.quantile(steps, (0.05, 0.5, 0.95))
    return bool(high - low < _UNEVEN * abs(middle))


def beside_what_turns_evenly(
    method: Method, film: Film, options: TrackOptions, progress: FrameProgress | None = None
) -> Track:
    """The track of a part by a method; of the one beside it, if it turns evenly and nobody points
    at it, where the frames confirm one that does not."""
    track = method(film, options, progress)
    chosen = options.pointed or options.pick > 1 or options.beside is not None
    if chosen or not turns_evenly(track.angle_deg[track.found]):
        return track
    try:
        other = method(film, replace(options, beside=track), progress)
    except TrackRefused:
        return track
    if turns_evenly(other.angle_deg[other.found]):
        return track
    x, y = track.pivot_px
    note = (
        f"the part about {x:.0f},{y:.0f} px turns on and on at an even speed, as a fan does, and "
        f"is left out; --pivot {x:.0f},{y:.0f} takes it"
    )
    return replace(other, notes=(note, *other.notes))
