"""A command as straight pieces, and the steps of an FMU under it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array

_SLOPE_STEP_S = 2e-3
"""An FMU's input is held within a step: under a sloping command steps are no longer."""
_APART_S = 1e-9
_JUMP_DEG = 1e-6


@dataclass(frozen=True)
class Pieces:
    """``value`` [deg] at ``start_s``, from there on with ``slope`` [deg/s], (pieces,) each.

    The first value holds before the first start.
    """

    start_s: Array
    value: Array
    slope: Array

    @classmethod
    def of(cls, time_s: Array, command_deg: Array, linear: bool) -> Pieces:
        """A recorded command's, its rows held or joined by lines."""
        slope = np.zeros(time_s.size)
        if linear:
            slope[:-1] = np.diff(command_deg) / np.diff(time_s)
        return cls(time_s, command_deg, slope)

    def at(self, time_s: Array) -> Array:
        """The command [deg] at instants, (instants,)."""
        piece = self._piece(time_s)
        gone = np.maximum(time_s - self.start_s[piece], 0.0)
        return np.asarray(self.value[piece] + self.slope[piece] * gone)

    def steps(
        self, nodes_s: Array, step_s: float | None = None, longest_s: float = math.inf
    ) -> tuple[Array, Array]:
        """Instants (steps + 1,) from the first node to the last, and the command of each step.

        A step ends at each jump or kink and at each node, and after ``longest_s``; the command is
        that in its middle. With ``step_s`` all steps are of that length.
        """
        first, last = float(nodes_s[0]), float(nodes_s[-1])
        if step_s is not None:
            time_s = np.arange(int(np.ceil((last - first) / step_s)) + 1) * step_s + first
        else:
            fine = np.arange(first, last, _SLOPE_STEP_S) if np.any(self.slope) else nodes_s[:0]
            fine = fine[self.slope[self._piece(fine)] != 0.0]
            time_s = np.unique(np.concatenate([self._ends(first, last), fine, nodes_s]))
            time_s = time_s[np.concatenate([[True], np.diff(time_s) > _APART_S])]
            time_s = _divided(time_s, longest_s)
        return np.asarray(time_s), self.at(0.5 * (time_s[1:] + time_s[:-1]))

    def _ends(self, first_s: float, last_s: float) -> Array:
        """Where pieces begin at which a step ends: not between short pieces that join."""
        lasts = np.diff(self.start_s)
        jump = np.abs(self.value[1:] - self.value[:-1] - self.slope[:-1] * lasts) > _JUMP_DEG
        long = lasts > _SLOPE_STEP_S
        kink = (long | np.append(long[1:], True))[: lasts.size]
        starts = self.start_s[np.concatenate([[True], jump | kink])]
        return np.asarray(starts[(starts > first_s) & (starts < last_s)])

    def _piece(self, time_s: Array) -> Array:
        found = np.searchsorted(self.start_s, time_s, side="right") - 1
        return np.asarray(np.maximum(found, 0))


def _divided(time_s: Array, longest_s: float) -> Array:
    """Instants with others between, so that no step is longer."""
    lasts = np.diff(time_s)
    parts = np.maximum(np.ceil(lasts / longest_s - 1e-9).astype(int), 1)
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    starts = np.repeat(time_s[:-1], parts) + np.repeat(lasts / parts, parts) * within
    return np.append(starts, time_s[-1])
