"""What of a model's error frames of the command would take, frames of any length and time.

To first order: by simulations of the model as it is, less what its parameters can take as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit._solution import Solution
from servosight.identify.problem import LOST_DEG, Problem
from servosight.identify.uncertainty import by_recording, clock_slope
from servosight.models.core import Array, Recording
from servosight.models.plant import Plant, Stimulus

_OFF = 0.003  # of a usual length: clocks of receivers
_PHASES, _PHASES_BESIDE = 12, 3  # of a frame; of those, to either side
_BESIDE = 3  # samples: the speed at the start of a window
_INITIAL = slice(4, 6)  # angle and speed, in a row of the plant's parameters


@dataclass(frozen=True)
class CommandFrames:
    """A frame's length [s], and the time of one on the recording's clock [s]."""

    period_s: float
    at_s: float

    def of(self, recording: Recording) -> Recording:
        """The recording with a command that acts once a frame."""
        return recording.in_frames(self.period_s, self.at_s)


def in_frames(
    recordings: Sequence[Recording], frames: Sequence[CommandFrames | None]
) -> tuple[Recording, ...]:
    """The recordings with commands that act once a frame, where they have frames."""
    pairs = zip(recordings, frames, strict=True)
    return tuple(one if own is None else own.of(one) for one, own in pairs)


def alone_in_frames(
    fit: Solution, r: int, recording: Recording, frames: CommandFrames
) -> tuple[Problem, Array]:
    """The fit of the one ``recording`` in these frames, number ``r`` of ``fit``, and its point."""
    problem = fit.problem
    own = [one.recording is None or one.recording == r for one in problem.coordinates]
    alone = replace(
        problem, recordings=(frames.of(recording),), masks=(problem.masks[r],), noises_deg=None
    )
    return alone, fit.outcome.point[own]


Found = tuple[float, float, CommandFrames]
"""The share of the squared error that frames take, how many times what they change that would be,
and the frames."""


@dataclass(frozen=True)
class FrameScene:
    """A recording, or a window of it, and what the model leaves of its angles.

    ``row`` (parameters,) are the plant's, ``straight_deg`` (samples,) its angles where the command
    acts at each row, ``left`` (samples,) what of the measured ones remains, by ``weight``, 0 where
    a sample is not scored. ``free`` (samples, columns) are orthonormal columns of what the fit's
    parameters, and a delay, can take of it.
    """

    plant: Plant
    recording: Recording
    row: Array
    straight_deg: Array
    left: Array
    weight: Array
    free: Array

    @classmethod
    def of(cls, fit: Solution, r: int) -> FrameScene:
        problem, point = fit.problem, fit.outcome.point
        columns = np.column_stack([fit.jacobian, clock_slope(problem, point, r)])
        free = by_recording(problem.masks, columns, fit.residual)[0][r]
        row = problem.rows(point[None, :], r)[0]
        weight = problem.weights[r] * problem.masks[r]
        return cls._left_by(problem.plant, problem.recordings[r], row, weight, free)

    @classmethod
    def _left_by(
        cls, plant: Plant, recording: Recording, row: Array, weight: Array, columns: Array
    ) -> FrameScene:
        size = np.linalg.norm(columns, axis=0)
        free = np.linalg.qr(columns[:, size > 0.0] / size[size > 0.0])[0]
        straight = plant.simulate(row[None], Stimulus.of(recording))[0]
        left = (recording.angle_deg - straight) * weight
        return cls(plant, recording, row, straight, left - free @ (free.T @ left), weight, free)

    def within(self, window_s: float) -> FrameScene:
        """The window of this length that has most of what is left, from the motion measured there
        on."""
        time_s, angle_deg = self.recording.time_s, self.recording.angle_deg
        total = np.concatenate([[0.0], np.cumsum(self.left**2)])
        ends = np.searchsorted(time_s, time_s + window_s, side="right")
        low = int(np.argmax(total[ends] - total[:-1]))
        inside = slice(low, int(ends[low]))
        row = self.row.copy()
        near = slice(max(low - _BESIDE, 0), low + _BESIDE + 1)
        if low:
            slope, value = np.polyfit(time_s[near] - time_s[low], angle_deg[near], 1)
            row[_INITIAL] = value, slope
        recording = replace(
            self.recording, time_s=time_s[inside], angle_deg=angle_deg[inside], sigma_deg=None,
            shared_deg=None, horn=None,
        )  # fmt: skip
        return FrameScene._left_by(
            self.plant, recording, row, self.weight[inside], self.free[inside]
        )

    @property
    def duration_s(self) -> float:
        return float(np.ptp(self.recording.time_s))

    def anywhere(self, usual_s: float) -> list[CommandFrames]:
        """Frames of about a usual length, at any time, close enough to tell the best ones."""
        fine = usual_s / 4.0 / max(self.duration_s, usual_s)
        count = np.ceil(_OFF / fine)
        start_s = float(self.recording.time_s[0])
        return [
            CommandFrames(period_s, start_s + period_s * phase)
            for period_s in (usual_s * (1.0 + fine * np.arange(-count, count + 1.0))).tolist()
            for phase in (np.arange(_PHASES) / _PHASES).tolist()
        ]

    def around(self, frames: CommandFrames, seen: FrameScene) -> list[CommandFrames]:
        """Frames about some that were found in a window, which are less sure beyond it."""
        fine_s = frames.period_s**2 / 8.0 / max(self.duration_s, frames.period_s)
        off_s = frames.period_s**2 / 4.0 / max(seen.duration_s, frames.period_s)
        count = np.ceil(off_s / fine_s)
        middle_s = float(seen.recording.time_s.mean())
        at_s = frames.at_s + frames.period_s * round((middle_s - frames.at_s) / frames.period_s)
        beside = np.arange(-_PHASES_BESIDE, _PHASES_BESIDE + 1.0) / _PHASES / _PHASES_BESIDE
        return [
            CommandFrames(period_s, at_s + period_s * phase)
            for period_s in (frames.period_s + fine_s * np.arange(-count, count + 1.0)).tolist()
            for phase in beside.tolist()
        ]

    def best(self, tried: Sequence[CommandFrames]) -> Found:
        """Of some frames the best ones, with the share of the squared error that they take and how
        many times what they change that would be."""
        square = max(float(self.left @ self.left), 1e-12)
        found = []
        for frames in tried:
            change = self._changed(frames)
            along, size = float(change @ self.left), max(float(change @ change), 1e-12)
            found.append(((2.0 * along - size) / square, along / size, frames))
        return max(found, key=lambda one: one[0])

    def _changed(self, frames: CommandFrames) -> Array:
        """By how much frames change the angles (samples,), beyond what the fit can take."""
        # What they delay in the mean, the fit has taken for a lag of the servo.
        later = frames.of(self.recording).shifted(0.5 * frames.period_s)
        seen = self.plant.simulate(self.row[None], Stimulus.of(later))[0]
        change = (np.nan_to_num(seen, nan=LOST_DEG) - self.straight_deg) * self.weight
        return np.asarray(change - self.free @ (self.free.T @ change))
