"""Stretches of long recordings: a selection simulates each model thousands of times.

A simulation passes through every row of the command. Where the recordings have more rows than a
budget, models are tried on stretches of the long ones instead, on the same clock. Which ones is
decided by the motion alone, before any model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.identify.problem import MOST_SAMPLES, largest_share
from servosight.models.core import Array, Mask, Recording

MOST_ROWS = 200_000
"""Rows of command and samples, of all recordings together, that a selection simulates."""
STRETCH_S = 12.0
"""Two rounds of the split's six blocks."""
LEAD_S = 1.0
"""A simulation begins so long before a stretch: play and friction remember where they were."""
LEAD_SAMPLES = 10
"""Samples that are kept where the simulation begins: they determine its initial state."""
COMMAND_BEFORE_S = 2.0
"""Command rows from so long before that act late."""
GRID_S = 0.01
"""The motion is averaged over so long."""
BINS = 12
EXTREME = 1e-3
"""Angles, speeds and accelerations beyond these quantiles share the outermost bins."""
TURNING = 0.02
"""Motion slower than this share of the largest speed reverses nothing."""

Spans = tuple[tuple[float, float], ...]
"""First and last time [s] of each stretch of a recording; none where it stays whole."""


def stretches(
    recordings: Sequence[Recording], most_rows: int = MOST_ROWS
) -> tuple[list[Spans], list[str]]:
    """For each recording the stretches to simulate, and a sentence for each that is cut.

    Recordings with fewer rows than their share of ``most_rows`` stay whole. Of the others those
    stretches are taken that together cover angles, speeds, accelerations and reversals best, as
    many as need no sample left out.
    """
    rows = [_rows(recording) for recording in recordings]
    share = largest_share(rows, most_rows)
    samples = largest_share([one.time_s.size for one in recordings], min(MOST_SAMPLES, most_rows))
    found: list[Spans] = []
    notes = []
    for recording, own in zip(recordings, rows, strict=True):
        part = min(share / own, samples / recording.time_s.size, 1.0)
        count = max(int(part * recording.duration_s / (LEAD_S + STRETCH_S)), 1)
        starts = _starts(recording)
        if own <= share or len(starts) <= count:
            found.append(())
            continue
        first = np.sort(starts[_covering(_features(recording, starts), count)])
        found.append(tuple((float(at) - LEAD_S, float(at) + STRETCH_S) for at in first))
        notes.append(_note(recording, first))
    return found, notes


def cut(recording: Recording, spans: Spans) -> list[Recording]:
    """The stretches of a recording, each with the command that acts in it; whole without any."""
    return [_piece(recording, *span) for span in spans] or [recording]


def kept(recording: Recording, span: tuple[float, float]) -> Mask:
    """The samples of a stretch, (samples,): at the beginning of its lead and behind the lead."""
    start, end = span
    time_s = recording.time_s
    inside = (time_s >= start) & (time_s <= end)
    first = np.cumsum(inside) <= LEAD_SAMPLES
    return np.asarray(inside & (first | (time_s >= start + LEAD_S)))


def _rows(recording: Recording) -> int:
    """Rows that a simulation passes through, with samples as thinned as a fit's are."""
    changes = recording.command_deg.size
    if recording.hold == "zero":
        changes = int(np.count_nonzero(np.diff(recording.command_deg))) + 1
    return changes + min(recording.time_s.size, MOST_SAMPLES)


def _starts(recording: Recording) -> Array:
    """Where stretches can begin to be scored [s]: side by side over the whole recording."""
    count = max(int((recording.duration_s - LEAD_S) / STRETCH_S), 0)
    return np.asarray(recording.time_s[0] + LEAD_S + STRETCH_S * np.arange(count))


def _features(recording: Recording, starts: Array) -> Array:
    """How much of each kind of motion every stretch holds, (stretches, kinds).

    Kinds are bins of angle, speed and acceleration, and of the angle where the motion reverses;
    each of the four adds up to one over the whole recording.
    """
    at = ((recording.time_s - recording.time_s[0]) / GRID_S).astype(np.int64)
    _, place, counts = np.unique(at, return_inverse=True, return_counts=True)
    angle = np.bincount(place, recording.angle_deg) / counts
    time_s = np.bincount(place, recording.time_s) / counts
    speed = np.gradient(angle, time_s)
    moving = np.flatnonzero(np.abs(speed) > TURNING * np.quantile(np.abs(speed), 1.0 - EXTREME))
    turned = np.flatnonzero(np.diff(np.sign(speed[moving])))
    quantities = [angle, speed, np.gradient(speed, time_s), angle[moving[turned + 1]]]
    times = [time_s, time_s, time_s, time_s[moving[turned + 1]]]
    tables = []
    for values, when in zip(quantities, times, strict=True):
        owner = np.floor((when - starts[0]) / STRETCH_S).astype(np.int64)
        table = np.zeros((len(starts), BINS))
        inside = (owner >= 0) & (owner < len(starts))
        np.add.at(table, (owner[inside], _binned(values)[inside]), 1.0)
        tables.append(table / max(table.sum(), 1.0))
    return np.hstack(tables)


def _binned(values: Array) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    if not values.size:
        return np.zeros(0, dtype=np.int64)
    low, high = np.quantile(values, [EXTREME, 1.0 - EXTREME])
    share = (values - low) / max(high - low, 1e-12)
    return np.asarray(np.clip(share * BINS, 0, BINS - 1).astype(np.int64))


def _covering(features: Array, count: int) -> list[int]:
    """The stretches that add most one after the other: of what is rare, a little adds much.

    Coverage is the sum of the square roots of what all chosen ones hold of each kind.
    """
    chosen: list[int] = []
    held = np.zeros(features.shape[1])
    for _ in range(count):
        gains = np.sqrt(held + features).sum(axis=1)
        gains[chosen] = -np.inf
        chosen.append(int(np.argmax(gains)))
        held += features[chosen[-1]]
    return chosen


def _piece(recording: Recording, start: float, end: float) -> Recording:
    samples = kept(recording, (start, end))
    rows_s = recording.command_time_s
    low = max(int(np.searchsorted(rows_s, start - COMMAND_BEFORE_S, side="right")) - 1, 0)
    high = int(np.searchsorted(rows_s, end, side="right")) + 1

    def of(values: Array | None) -> Array | None:
        return None if values is None else np.ascontiguousarray(values[samples])

    return replace(
        recording,
        time_s=recording.time_s[samples],
        angle_deg=recording.angle_deg[samples],
        sigma_deg=of(recording.sigma_deg),
        shared_deg=of(recording.shared_deg),
        command_time_s=np.ascontiguousarray(rows_s[low:high]),
        command_deg=np.ascontiguousarray(recording.command_deg[low:high]),
    )


def _note(recording: Recording, starts: Array) -> str:
    used = STRETCH_S * len(starts)
    when = ", ".join(f"{at:.0f}" for at in starts)
    return (
        f"{recording.name}: too long to try models on all of it: {len(starts)} stretches of "
        f"{STRETCH_S:g} s are used instead of its {recording.duration_s:,.0f} s, those that cover "
        f"angles, speeds, accelerations and reversals best (from {when} s on). This makes sigmas "
        "larger, "
        f"by a factor of {np.sqrt(recording.duration_s / used):.2g} at most; `servosight identify` "
        f"with `--effects` fits the whole recording"
    )
