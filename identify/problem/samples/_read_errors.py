"""Samples of a log that no servo produced: single wrong reads, and old values read again.

Both are faults of the bus between servo and log. A wrong read jumps away and back at an
acceleration that the recording shows nowhere else. An old value is exactly that of the sample
before, between samples that move, and the next one makes up for it. Such samples are left out of
the angle; the command stays whole, so that the simulation passes through them.

The limits are on the safe side: a sample that the servo may have produced stays. Therefore small
wrong reads stay, and a sensor that is slower than the log is recognised in quick motion alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.identify.problem._setups import setup_doubts
from servosight.identify.problem.noise import resolution_deg
from servosight.identify.problem.samples._old_values import held_values, old_values
from servosight.identify.problem.samples._read_limits import LIMITS, ReadErrorLimits
from servosight.models.core import Array, Mask, Recording, views


def usable_views(
    recordings: Sequence[Recording], limits: ReadErrorLimits = LIMITS
) -> tuple[list[Recording], list[str]]:
    """Recordings and their horns' (see ``views``) without faults of the bus, and what was left out.

    One sentence for each kind of fault in each recording, behind those on how a log was read; and
    where the recordings differ in what they are fitted as if they had in common.
    """
    found, notes = [], setup_doubts(recordings)
    for recording in views(recordings):
        notes += [note for note in recording.notes if recording.side != "horn"]
        wrong = wrong_reads(recording, limits)
        kept = without(recording, wrong)
        old = np.zeros(recording.time_s.size, dtype=bool)
        old[~wrong] = old_values(kept, limits) | held_values(kept, limits)
        found.append(without(recording, wrong | old))
        for which, what in (
            (wrong, "read errors, which jump away and back faster than the servo ever moves,"),
            (old, "old values, read again while the servo moves,"),
        ):
            if np.any(which):
                first_s = recording.time_s[np.argmax(which)]
                notes.append(
                    f"{recording.name}: {int(which.sum()):,} of {which.size:,} samples are {what} "
                    f"and were left out, the first at {first_s:.6g} s"
                )
    return found, notes


def without(recording: Recording, left_out: Mask) -> Recording:
    """The recording without the samples ``left_out`` (samples,); its command stays whole."""
    if not np.any(left_out):
        return recording

    def kept(values: Array | None) -> Array | None:
        return None if values is None else np.ascontiguousarray(values[~left_out])

    return replace(
        recording,
        time_s=np.ascontiguousarray(recording.time_s[~left_out]),
        angle_deg=np.ascontiguousarray(recording.angle_deg[~left_out]),
        sigma_deg=kept(recording.sigma_deg),
        shared_deg=kept(recording.shared_deg),
    )


def wrong_reads(recording: Recording, limits: ReadErrorLimits = LIMITS) -> Mask:
    """Which samples jump away and back as no servo can, (samples,).

    >>> time_s = np.arange(0.0, 2.0, 0.01)
    >>> angle_deg = 10.0 * np.sin(5.0 * time_s)
    >>> angle_deg[120] += 22.5
    >>> log = Recording.from_arrays(time_s=time_s, angle_deg=angle_deg, command_deg=np.sin(time_s))
    >>> np.flatnonzero(wrong_reads(log)).tolist()
    [120]
    """
    time_s, angle = recording.time_s, recording.angle_deg
    wrong = np.zeros(angle.size, dtype=bool)
    if angle.size <= 4 * limits.around:
        return wrong
    spread = float(np.ptp(np.quantile(angle, (0.02, 0.98))))
    least = max(limits.steps * resolution_deg(angle), limits.range_share * spread, 1e-9)
    runs = [
        (away, first, length)
        for length in range(1, limits.longest + 1)
        for first, away in _away(time_s, angle, length, least, limits)
    ]
    chosen: list[tuple[float, int, int]] = []
    for away, first, length in sorted(runs, key=lambda run: (-run[0] / (run[2] + 1) ** 2, run)):
        own = slice(first - 1, first + length + 1)
        if not np.any(wrong[own]):
            wrong[own] = True
            chosen.append((away, first, length))
    chosen = [
        run
        for run in _impossible(time_s, angle, chosen, limits)
        if not _commanded(recording, run, limits)
    ]
    wrong[:] = False
    for _, first, length in chosen:
        wrong[first : first + length] = True
    return wrong if wrong.sum() <= limits.most * wrong.size else np.zeros_like(wrong)


def _off_line(time_s: Array, angle: Array, length: int) -> tuple[Array, Array, Array]:
    """How far runs of ``length`` samples are from the line between their neighbours [deg].

    (runs, length), the first run beginning at sample 2; then (runs,) how far the neighbours are
    apart, and how far the second is from where the speeds beside the run lead to from the first.
    """
    first = np.arange(2, angle.size - length - 1)
    before, behind = first - 1, first + length
    inside = first[:, None] + np.arange(length)
    share = (time_s[inside] - time_s[before, None]) / (time_s[behind] - time_s[before])[:, None]
    took, change = time_s[behind] - time_s[before], angle[behind] - angle[before]
    speed = np.diff(angle) / np.diff(time_s)
    expected = 0.5 * (speed[before - 1] + speed[behind]) * took
    off = angle[inside] - angle[before, None] - share * change[:, None]
    return off, np.abs(change), np.abs(change - expected)


def _away(
    time_s: Array, angle: Array, length: int, least: float, limits: ReadErrorLimits
) -> list[tuple[int, float]]:
    """First samples of runs that stand out from what is around them, and how far they do [deg]."""
    off, change, jump = _off_line(time_s, angle, length)
    away = np.abs(off).min(axis=1)
    one_side = np.abs(np.sign(off).sum(axis=1)) == length
    single = np.abs(_off_line(time_s, angle, 1)[0][:, 0])
    found = []
    back = (change <= away) & (jump <= limits.return_share * away)
    for run in np.flatnonzero(one_side & (away >= least) & back):
        left = single[max(run - limits.around, 0) : max(run - 1, 0)]
        right = single[run + length + 1 : run + length + limits.around]
        # The median bears with a second wrong read nearby.
        near = float(np.median(np.concatenate([left, right])))
        if away[run] > limits.local * near:
            found.append((int(run) + 2, float(away[run])))
    return found


def _impossible(
    time_s: Array, angle: Array, runs: list[tuple[float, int, int]], limits: ReadErrorLimits
) -> list[tuple[float, int, int]]:
    """The runs whose acceleration is beyond that of all samples outside of such runs."""
    single = np.abs(_off_line(time_s, angle, 1)[0][:, 0])
    other = np.ones(single.size, dtype=bool)
    for _, first, length in runs:
        other[max(first - 3, 0) : first + length - 1] = False
    largest = float(single[other].max(initial=0.0))
    # The same acceleration carries a longer run further from the line, as its time squared.
    return [run for run in runs if run[0] > limits.acceleration * largest * (run[2] + 1) ** 2 / 4.0]


def _commanded(recording: Recording, run: tuple[float, int, int], limits: ReadErrorLimits) -> bool:
    """True where the command goes out and back as shortly as the run, a little before it."""
    away, first, length = run
    time_s, rows_s = recording.time_s, recording.command_time_s
    end_s = time_s[first + length]
    longest_s = 2.0 * (end_s - time_s[first - 1])
    start_s = end_s - limits.response_s - longest_s
    inside = rows_s[(rows_s > start_s) & (rows_s <= end_s)]
    for row_s in (start_s, *inside):
        near = inside[(inside > row_s) & (inside <= row_s + longest_s)]
        path = recording.command_at(np.concatenate([[row_s], near]))
        there_and_back = float(np.abs(np.diff(path)).sum() - abs(path[-1] - path[0])) / 2.0
        if there_and_back > limits.command_share * away:
            return True
    return False
