"""Errors that the frames of a standstill share.

A tracker learns the surface and what is behind it from some frames of the video. Their noise is in
that picture, so that at one angle it is wrong by the same amount in every frame: however many
frames show a surface at rest, they do not average it out. While the surface moves, the amount
changes from frame to frame, and is part of each frame's own sigma.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Recording, runs_of

LEARNT_SHARE = 0.65
"""The shared error in a frame's sigma. On seven films of a rehearsed servo, the fourteen rests
before and after the command were off by 0.97 mdeg rms, at a sigma of 1.5 mdeg."""
_LEAST_FRAMES = 5
_MOVED = 6.0  # sigma from frame to frame
_ALIKE_DEG = 0.3


def standstill_errors(recording: Recording) -> Array:
    """Change of the angles [deg] by one sigma of the error of each standstill; (samples, errors).

    Standstills at angles that differ by less than 0.3 deg have one error. (samples, 0) where no
    tracker has measured the angle.
    """
    angle, sigma = recording.angle_deg, recording.sigma_deg
    if recording.shared_deg is None or sigma is None:
        return np.zeros((angle.size, 0))
    still = np.abs(np.diff(angle)) < _MOVED * np.maximum(sigma[1:], sigma[:-1])
    places: list[float] = []
    columns: list[Array] = []
    for begin, last in runs_of(still).tolist():
        end = last + 1
        if end - begin < _LEAST_FRAMES:
            continue
        place = float(np.median(angle[begin:end]))
        near = [n for n, other in enumerate(places) if abs(other - place) < _ALIKE_DEG]
        if not near:
            places.append(place)
            columns.append(np.zeros(angle.size))
        column = columns[near[0] if near else -1]
        column[begin:end] = LEARNT_SHARE * sigma[begin:end]
    return np.column_stack(columns) if columns else np.zeros((angle.size, 0))
