"""Samples of a log that no servo produced: single wrong reads, and old values read again.

Both are faults of the bus between servo and log. A wrong read jumps away and back at an
acceleration that the recording shows nowhere else, where the motion beside it is smooth. An old
value is exactly that of the sample before, between samples that move, and the next one makes up for
it. Such samples are left out of the angle; the command stays whole, so that the simulation passes
through them.

The limits are on the safe side: a sample that the servo may have produced stays. Therefore small
wrong reads stay, and a sensor that is slower than the log is recognised in quick motion alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.problem._setups import setup_doubts
from servosight.identify.problem.noise import resolution_deg
from servosight.identify.problem.samples._old_values import held_values, old_values
from servosight.identify.problem.samples._read_limits import LIMITS, ReadErrorLimits
from servosight.identify.problem.samples._smooth_path import bends, passed_by
from servosight.identify.problem.samples._wrong_runs import (
    Path,
    Run,
    beyond_motion,
    commanded,
    crowded,
    isolated,
)
from servosight.models.core import Array, Mask, Recording, views


def usable_views(recordings: Sequence[Recording]) -> tuple[list[Recording], list[str]]:
    """Recordings and their horns' (see ``views``) without faults of the bus, and what was left out.

    One sentence for each kind of fault in each recording, behind those on how a log was read; and
    where the recordings differ in what they are fitted as if they had in common.
    """
    found, notes = [], setup_doubts(recordings)
    for recording in views(recordings):
        notes += [note for note in recording.notes if recording.side != "horn"]
        reads = judged_reads(recording)
        wrong = reads.wrong
        kept = without(recording, wrong)
        old = np.zeros(recording.time_s.size, dtype=bool)
        old[~wrong] = old_values(kept) | held_values(kept)
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
        notes += _doubts(recording, replace(reads, doubtful=reads.doubtful & ~old))
    return found, notes


def _doubts(recording: Recording, reads: JudgedReads) -> list[str]:
    """A sentence on samples that look like read errors and are fitted all the same."""
    if not np.any(reads.doubtful):
        return []
    first_s = recording.time_s[np.argmax(reads.doubtful)]
    return [
        f"{recording.name}: {int(reads.doubtful.sum()):,} of {reads.doubtful.size:,} samples jump "
        f"away and back like read errors, the first at {first_s:.6g} s, and are fitted all the "
        f"same, as {reads.why}: if the servo did not move so, remove their rows from the log or "
        "repair the connection and record again"
    ]


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


@dataclass(frozen=True)
class JudgedReads:
    """``wrong``: samples to leave out; ``doubtful``: those that only look so and stay.

    Both (samples,). ``why`` says why the doubtful ones stay.
    """

    wrong: Mask
    doubtful: Mask
    why: str = ""


def judged_reads(recording: Recording, limits: ReadErrorLimits = LIMITS) -> JudgedReads:
    """The read errors of a recording, and what may be some but is not plain.

    >>> time_s = np.arange(0.0, 2.0, 0.01)
    >>> angle_deg = 10.0 * np.sin(5.0 * time_s)
    >>> angle_deg[120] += 22.5
    >>> log = Recording.from_arrays(time_s=time_s, angle_deg=angle_deg, command_deg=np.sin(time_s))
    >>> np.flatnonzero(judged_reads(log).wrong).tolist()
    [120]
    """
    time_s, angle = recording.time_s, recording.angle_deg
    none = np.zeros(angle.size, dtype=bool)
    if angle.size <= 4 * limits.around or limits.longest < 1:
        return JudgedReads(none, none)
    raw = bends(time_s, angle, np.arange(angle.size))
    spread = float(np.ptp(np.quantile(angle, (0.02, 0.98))))
    least = max(limits.steps * resolution_deg(angle), limits.range_share * spread, 1e-9)
    # A fifth of the samples stands in no wrong read's neighbourhood even where a third is wrong.
    noise = float(np.quantile(raw, 0.2)) / 0.25
    price = 2.0 * max(least, 3.5 * noise)
    passed = passed_by(time_s, angle, price, limits.longest, limits.at_ends)
    crowd = crowded(passed, limits)
    runs = isolated(recording, passed, limits)
    clear = [run for run in runs if not np.any(crowd[run.samples])]
    path = Path(recording, ~_all_of(clear, angle.size))
    largest = path.largest_bend(int(limits.unresolved * len(clear)))
    wrong, doubtful, away = none.copy(), none.copy(), none.copy()
    for run in runs:
        if commanded(recording, run, limits.answers_share, limits):
            continue
        large = np.abs(run.away_deg) >= least
        away[run.samples] = large
        if not run.near_end(angle.size):
            doubtful[run.samples] = large & beyond_motion(run, path, limits.doubt * largest, limits)
        if not np.any(crowd[run.samples]) and not commanded(
            recording, run, limits.command_share, limits
        ):
            wrong[run.samples] = large & beyond_motion(run, path, largest, limits)
    wrong |= passed & _defaults(angle, wrong, limits)
    if np.sum(wrong | away) > limits.most * wrong.size:
        return JudgedReads(none, wrong | away, f"they are over {100.0 * limits.most:g} % of all")
    return JudgedReads(
        wrong, doubtful & ~wrong, "the command or the rest of the angle moves about as fast"
    )


def _all_of(runs: Sequence[Run], size: int) -> Mask:
    """The samples of all runs, (size,)."""
    found = np.zeros(size, dtype=bool)
    for run in runs:
        found[run.samples] = True
    return found


def _defaults(angle: Array, wrong: Mask, limits: ReadErrorLimits) -> Mask:
    """Which samples have exactly the value of several wrong reads, as of a read that failed."""
    values, counts = np.unique(angle[wrong], return_counts=True)
    often = max(limits.same_value, limits.same_share * wrong.sum())
    return np.isin(angle, values[counts >= often])
