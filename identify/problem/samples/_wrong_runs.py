"""Which of the samples that the smoothest path passes by no servo can have produced.

A servo's own jerk, a peak or an impact, may be passed by as well. It differs in that the motion
beside it is about as rough, or that other motion of the recording is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.identify.problem.samples._read_limits import ReadErrorLimits
from servosight.identify.problem.samples._smooth_path import bends
from servosight.models.core import Array, Mask, Recording, runs_of


@dataclass(frozen=True)
class Run:
    """Samples ``first`` to ``first + length - 1``, ``away_deg`` (length,) from what is around."""

    first: int
    away_deg: Array

    @property
    def samples(self) -> slice:
        """Where the run is in the log."""
        return slice(self.first, self.first + self.away_deg.size)

    def near_end(self, size: int) -> bool:
        """Whether too little is known of the motion on one side to tell its speed there."""
        return self.first < 2 or self.samples.stop > size - 2

    @property
    def least_deg(self) -> float:
        """What even the nearest of its samples is away [deg]."""
        return float(np.min(np.abs(self.away_deg)))

    @property
    def most_deg(self) -> float:
        """What the farthest of its samples is away [deg]."""
        return float(np.max(np.abs(self.away_deg)))


def isolated(recording: Recording, left_out: Mask, limits: ReadErrorLimits) -> list[Run]:
    """The runs of ``left_out`` (samples,) away from a motion that is smooth beside them."""
    path = Path(recording, ~left_out)
    runs = [path.run(first, end - first) for first, end in runs_of(left_out).tolist()]
    return [run for run in runs if _stands_out(run, path, limits)]


def crowded(left_out: Mask, limits: ReadErrorLimits) -> Mask:
    """Where nearly every other sample is ``left_out``: an oscillation, or nobody knows, (samples,).

    Of two alternating angles either may be the servo's.
    """
    width = 2 * limits.around + 1
    share = np.convolve(left_out, np.full(width, 1.0 / width), mode="same")
    many: Mask = left_out & (share > limits.crowded)
    return many


class Path:
    """The samples of a recording that are kept, and how rough the motion through them is."""

    def __init__(self, recording: Recording, kept: Mask) -> None:
        """``kept`` (samples,) holds at least three."""
        self.places = np.flatnonzero(kept)
        self.time_s, self.angle = recording.time_s, recording.angle_deg
        seen = self.angle[self.places]
        self.bends = bends(self.time_s[self.places], seen, self.places)
        self.largest_move = float(np.max(np.abs(np.diff(seen)) / np.diff(self.places)))

    def largest_bend(self, unresolved: int) -> float:
        """The largest bend but those of ``unresolved`` places [deg]."""
        return float(np.sort(self.bends)[-1 - min(4 * unresolved, self.bends.size - 1)])

    def beside(self, run: slice, width: int) -> Array:
        """How rough the ``width`` kept samples on either side of a run are [deg]."""
        place = int(np.searchsorted(self.places, run.start))
        return self.bends[max(place - width, 0) : place + width]

    def run(self, first: int, length: int) -> Run:
        """A run with what each sample is away from the line between the kept ones beside it.

        At an end of the recording: from the nearest kept one.
        """
        inside = slice(first, first + length)
        if first == 0 or first + length == self.angle.size:
            near = self.angle[length if first == 0 else first - 1]
            return Run(first, self.angle[inside] - near)
        ends = [first - 1, first + length]
        line = np.interp(self.time_s[inside], self.time_s[ends], self.angle[ends])
        return Run(first, self.angle[inside] - line)

    def at_end(self, run: Run) -> bool:
        """Whether nothing is known of the motion on one side of the run."""
        return run.first == 0 or run.samples.stop == self.angle.size

    def misfit(self, run: Run) -> float:
        """How far the other side of a run is from where the motion on its two sides leads [deg]."""
        if self.at_end(run):
            return 0.0
        behind = int(np.searchsorted(self.places, run.first))
        beside = self.places[max(behind - 2, 0) : behind + 2]
        slopes = np.diff(self.angle[beside]) / np.diff(self.time_s[beside])
        across = min(behind, 2) - 1
        took = self.time_s[self.places[behind]] - self.time_s[self.places[behind - 1]]
        return float(np.abs(slopes[across] - np.mean(np.delete(slopes, across))) * took)

    def crossing(self, run: Run) -> float:
        """How far the servo moves from one side of the run to the other, a step of the path."""
        if self.at_end(run):
            return 0.0
        before, behind = run.first - 1, run.samples.stop
        return float(2.0 * abs(self.angle[behind] - self.angle[before]) / (behind - before))


def _stands_out(run: Run, path: Path, limits: ReadErrorLimits) -> bool:
    """Whether the motion beside the run is smooth, in what is kept and in all that was read."""
    near = path.beside(run.samples, limits.around)
    closest = path.beside(run.samples, 3)
    away = run.most_deg
    return (
        away > limits.local * float(np.median(near))
        and float(closest.max()) <= limits.return_share * away
        and path.misfit(run) <= limits.return_share * away
        and path.crossing(run) <= away
    )


def beyond_motion(run: Run, path: Path, largest_deg: float, limits: ReadErrorLimits) -> Mask:
    """Which samples of the run need more acceleration than the rest of the recording, (length,).

    The same acceleration carries further the longer it lasts; yet it cannot begin or end within
    a sample, so that a long run with steep sides is no motion either.
    """
    away, most = np.abs(run.away_deg), limits.acceleration * largest_deg
    if run.near_end(path.angle.size):
        step = limits.acceleration * path.largest_move * away.size
        leaps: Mask = away > max(2.0 * most, step)
        return leaps
    ahead = np.arange(1, away.size + 1)
    further = ahead * ahead[::-1]
    if min(away[0], away[-1]) > 2.0 * most:
        further = np.minimum(further, 2)
    beyond: Mask = away > most * further
    return beyond


def commanded(recording: Recording, run: Run, share: float, limits: ReadErrorLimits) -> bool:
    """True where the command goes out and back as shortly as the run, a little before it.

    It does by more than ``share`` of what the run is away.
    A longer pulse counts where it is as large as the run: a servo may ring after it. At an end of
    the recording, where nobody knows whether the angle comes back, a command that goes out counts.
    """
    time_s, rows_s = recording.time_s, recording.command_time_s
    end_s = float(time_s[min(run.samples.stop, time_s.size - 1)])
    short_s = 2.0 * (end_s - float(time_s[max(run.first - 1, 0)]))
    long_s = max(short_s, limits.pulse_s)
    start_s = end_s - limits.response_s - long_s
    inside = rows_s[(rows_s > start_s) & (rows_s <= end_s)]
    large = share * run.least_deg
    if run.near_end(time_s.size):
        return float(np.ptp(recording.command_at(np.append(start_s, inside)))) > large
    pulses = ((short_s, large), (long_s, run.least_deg))
    return any(
        _there_and_back(recording, row_s, inside[(inside > row_s) & (inside <= row_s + took)]) > deg
        for took, deg in pulses
        for row_s in (end_s - limits.response_s - took, *inside)
    )


def _there_and_back(recording: Recording, row_s: float, rows_s: Array) -> float:
    """How far the command goes out and back from ``row_s`` to the last of ``rows_s`` [deg]."""
    path = recording.command_at(np.append(row_s, rows_s))
    return float(np.abs(np.diff(path)).sum() - abs(path[-1] - path[0])) / 2.0
