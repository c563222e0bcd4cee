"""Command and angle that were taken for each other: an angle that jumps, and stands between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Recording

_JUMP, _TIMES, _LEAST = 0.1, 3.0, 3
"""A jump of the angle is larger than a tenth of its range and than three times the largest change
of the command between two samples. Three of them are needed: fewer may be read errors."""
_MOVES = 0.2
"""A command that is a measured angle repeats its value at less than this share of the samples."""


def exchanged_notes(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """A sentence for each recording whose angle looks like a command and its command like an angle.

    A servo smooths its command: from one sample to the next the angle moves by no more than the
    command does at most. Where it jumps and is exactly the same before and after it was set, not
    measured.

    >>> time_s = np.arange(200) * 0.01
    >>> steps = 10.0 * np.sign(np.sin(8.0 * time_s))
    >>> smooth = 9.0 * np.sin(8.0 * time_s - 0.3)
    >>> [len(exchanged_notes([Recording("log", time_s, command, time_s, angle)]))
    ...  for command, angle in ((steps, smooth), (smooth, steps))]
    [0, 1]
    """
    notes = []
    for one in recordings:
        command_deg = np.abs(np.diff(one.command_at(one.time_s)))
        angle_deg = np.abs(np.diff(one.angle_deg))
        least = max(_JUMP * float(np.ptp(one.angle_deg)), _TIMES * float(command_deg.max()))
        jumps = 1 + np.flatnonzero(angle_deg[1:-1] > least)
        stands = (angle_deg[jumps - 1] == 0.0) & (angle_deg[jumps + 1] == 0.0)
        if stands.sum() >= _LEAST and np.mean(command_deg == 0.0) < _MOVES:
            notes.append(
                f"{one.name}: the angle jumps {int(stands.sum())} times from one sample to the "
                f"next, by up to {angle_deg.max():.3g} deg, and stands still before and after, and "
                f"the command moves by {command_deg.max():.3g} deg at most; check whether command "
                "and angle are exchanged"
            )
    return tuple(notes)
