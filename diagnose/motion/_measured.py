"""Speed, acceleration and the command's swings of a recording, without any model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.diagnose.residuals import turning_points
from servosight.models.core import Array, Recording

WINDOW_S = 0.05
"""Speed and acceleration are those of a parabola through the angles of so long."""
FEWEST = 5
"""Samples in a window, where they are further apart than that."""
STILL = 0.01
"""Of its largest speed, below which a servo is at rest if it is so for two samples."""
JUMP = 0.25
"""A command that jumps by this share of its largest swing excites high frequencies, too."""


@dataclass(frozen=True)
class MeasuredMotion:
    """What the servo did, and what it was commanded to do, at each sample of a recording.

    All properties are (samples,).
    """

    recording: Recording

    @property
    def angle_deg(self) -> Array:
        """The measured angle."""
        return self.recording.angle_deg

    @property
    def speed_deg_s(self) -> Array:
        """Magnitude of the measured speed."""
        return np.abs(self._parabola[0])

    @property
    def turns(self) -> Array:
        """How often the servo has turned back by then; each sample at rest counts for two turns."""
        speed = self._parabola[0]
        slow = np.abs(speed) <= STILL * np.max(np.abs(speed))
        rests = slow & np.concatenate([[False], slow[:-1]])
        turned = np.diff(speed < 0.0, prepend=speed[0] < 0.0)
        return np.cumsum(np.where(rests, 2, turned))

    @property
    def acceleration_deg_s2(self) -> Array:
        """Magnitude of the measured acceleration."""
        return np.abs(self._parabola[1])

    @property
    def demand_deg(self) -> Array:
        """Magnitude of what the loop asks of its drive: the position error, at relative gain 1.

        Less its median, as a camera's angles have a zero of their own in each recording.
        """
        error = self.recording.command_at(self.recording.time_s) - self.angle_deg
        return np.abs(self.recording.relative_gain * (error - np.median(error)))

    @property
    def disturbance(self) -> Array:
        """Magnitude of the known disturbance, in its own unit; 0 where none is known."""
        return np.abs(self.recording.disturbance_at(self.recording.time_s))

    @property
    def swing_deg(self) -> Array:
        """Size of the swing that the command makes, from one turning point to the next."""
        return self._swings[0]

    @property
    def frequency_hz(self) -> Array:
        """Frequency of an oscillation whose half period lasts as long as that swing."""
        return self._swings[1]

    @cached_property
    def jumps(self) -> bool:
        """True where the command has jumps: these excite all frequencies."""
        if self.recording.hold == "linear" or self.recording.command_deg.size < 2:
            return False
        command = self.recording.command_at(self.recording.time_s)
        steps = np.abs(np.diff(command))
        usual = 4.0 * float(np.quantile(steps, 0.9))
        return bool(steps.max() > max(JUMP * float(np.ptp(command)), usual))

    @cached_property
    def _parabola(self) -> tuple[Array, Array]:
        """First and second derivative of a local parabola, least squares."""
        time_s, angle = self.recording.time_s, self.recording.angle_deg
        step = float(np.median(np.diff(time_s)))
        half = min(max(round(0.5 * WINDOW_S / step), FEWEST // 2), (time_s.size - 1) // 2)
        # Near both ends the nearest whole window counts.
        centre = np.clip(np.arange(time_s.size), half, time_s.size - 1 - half)
        rows = centre[:, None] + np.arange(-half, half + 1)
        lag = time_s[rows] - time_s[centre][:, None]
        scale = np.max(np.abs(lag), axis=1)
        unit = lag / scale[:, None]
        table = np.stack([np.ones_like(unit), unit, unit**2], axis=2)
        away = angle[rows] - angle[centre][:, None]
        normal = np.einsum("nij,nik->njk", table, table)
        right = np.einsum("nij,ni->nj", table, away)
        found = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
        return found[:, 1] / scale, 2.0 * found[:, 2] / scale**2

    @cached_property
    def _swings(self) -> tuple[Array, Array]:
        time_s = self.recording.time_s
        command = self.recording.command_at(time_s)
        turns = np.unique(np.concatenate([[0], turning_points(command), [time_s.size - 1]]))
        owner = np.clip(np.searchsorted(turns, np.arange(time_s.size), "right") - 1, 0, None)
        owner = np.minimum(owner, turns.size - 2)
        size = np.abs(np.diff(command[turns]))
        length = np.maximum(np.diff(time_s[turns]), 1e-9)
        # Whether the motion before the first and behind the last turning point is a whole swing is
        # not known: its frequency is no more than that of its neighbour.
        rate = 0.5 / length
        if rate.size > 1:
            rate[0], rate[-1] = min(rate[0], rate[1]), min(rate[-1], rate[-2])
        return size[owner], rate[owner]
