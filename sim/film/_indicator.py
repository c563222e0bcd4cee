"""The light on the bench that shows the command: its start, its upper half, or each step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, runs_of

SHOWS = ("start", "above", "step")


@dataclass(frozen=True)
class Indicator:
    """What the light shows; the default goes on when the command first changes and stays on.

    ``shows``: "start"; "above", on while the command is above the middle of its range; "step",
    which changes with every change of the command.
    """

    shows: str = "start"

    def lit(self, time_s: Array, command_deg: Array, start_s: float | None) -> Array:
        """Stretches of time in which it is on, (stretches, 2) [s].

        ``command_deg`` (n,) on the grid ``time_s``; ``start_s`` is when it first changes.
        """
        if start_s is None:
            return np.empty((0, 2))
        if self.shows == "start":
            return np.array([[start_s, np.inf]])
        if self.shows == "above":
            on = command_deg > 0.5 * (command_deg.min() + command_deg.max())
        else:
            on = np.concatenate([[0], np.cumsum(np.diff(command_deg) != 0.0)]) % 2 == 1
        starts, ends = runs_of(on).T
        until = np.append(time_s, np.inf)
        return np.column_stack([time_s[starts], until[ends]])


def share(lit: Array, opens_s: Array, closes_s: Array) -> Array:
    """Share of each exposure (rows,) in which the light is on."""
    length = closes_s - opens_s
    both = np.minimum(closes_s[:, None], lit[:, 1]) - np.maximum(opens_s[:, None], lit[:, 0])
    return np.asarray(np.clip(both, 0.0, None).sum(1) / length)
