"""How much of an error repeats where the command does: the rest is the servo's own floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals import Judged, lagged_sums
from servosight.identify.problem import command_periods, period_table
from servosight.models.core import Array, Recording, degrees

SAME_COMMAND = 0.01
"""Commands of two runs are the same where they differ by less than this share of the range, rms."""
SAME_RUN_DEG = 1e-9
"""Runs that differ by no more are one run, given twice."""
LARGEST = 0.01
"""Share of the moved range up to which the difference of such runs is taken for scatter."""
FEWEST = 50
"""Samples that runs must have in common."""


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """The last model's error where a command was given several times.

    ``kind`` is "periods" of one recording or "runs", recordings with the same command; ``count``
    of them are compared. ``scatter_deg`` is the rms of what differs from time to time, noise of the
    measurement included: no model of the command alone can be better. ``repeating_deg`` is the rms
    of what is the same each time, and ``share`` its share of the squared error.
    """

    kind: str
    recordings: tuple[str, ...]
    count: int
    scatter_deg: float
    repeating_deg: float
    share: float
    sentence: str


def repeated(judged: Sequence[Judged]) -> Repeated | None:
    """What repeats, from periods or from runs, whichever has more samples; None without either."""
    tables = [("periods", *one) for one in _periods(judged)]
    tables += [("runs", *one) for one in _runs(judged)]
    if not tables:
        return None
    kind, names, table = max(tables, key=lambda one: one[2].size)
    count = len(table)
    mean = table.mean(axis=0)
    scatter = float(np.sum((table - mean) ** 2) / ((count - 1) * mean.size))
    # A mean of scattered values is off by the scatter over their number.
    repeating = max(float(np.mean(mean**2)) - scatter / count, 0.0)
    share = repeating / max(repeating + scatter, 1e-300)
    sizes = float(np.sqrt(scatter)), float(np.sqrt(repeating))
    return Repeated(
        kind=kind,
        recordings=names,
        count=count,
        scatter_deg=sizes[0],
        repeating_deg=sizes[1],
        share=share,
        sentence=_words(kind, names, count, sizes, share),
    )


def _words(
    kind: str, names: Sequence[str], count: int, sizes: tuple[float, float], share: float
) -> str:
    scatter, repeating = sizes
    times = (
        f"{count} periods of the command on {names[0]}"
        if kind == "periods"
        else f"{count} runs with the same command ({', '.join(names)})"
    )
    return (
        f"Of the squared error over {times}, {100.0 * share:.0f} % repeats, {degrees(repeating)} "
        f"rms; the part that differs between repetitions is {degrees(scatter)} rms, and no model "
        f"of the command alone can be better than that."
    )


def _periods(judged: Sequence[Judged]) -> list[tuple[tuple[str, ...], Array]]:
    """Errors (periods, samples) of each recording whose command repeats itself."""
    found: list[tuple[tuple[str, ...], Array]] = []
    for one in judged:
        lag = next(command_periods(one.recording), None)
        if lag is not None:
            found.append(((one.recording.name,), period_table(one.error_deg, lag)))
    return found


@dataclass(frozen=True)
class Scatter:
    """By how much runs with the same command differ, noise included: ``rms_deg``.

    ``worth`` is how many independent samples one sample is worth in a mean square, as what differs
    is autocorrelated; ``freedom`` how many independent samples the rms is known from.
    """

    rms_deg: float
    worth: float
    freedom: float


def run_scatter(recordings: Sequence[Recording]) -> Scatter | None:
    """By how much runs with the same command differ; None where few do.

    It is the floor of the servo itself: no model of the command alone predicts the next run more
    closely. From every run its mean goes and, as runs may be a little apart in time, the command in
    the proportion in which the angles follow it. Runs that are repeated must be most of the
    samples: what differs between two of many recordings says nothing of the others.
    """
    groups = _groups(recordings)
    known = sum(one.time_s.size for group in groups for one in group)
    if 2 * known < sum(one.time_s.size for one in recordings) or not groups:
        return None
    differences = [_differences_deg(group) for group in groups]
    freedom = sum((len(one) - 1) * one.shape[1] for one in differences)
    squares = sum(float(np.sum(one**2)) for one in differences)
    worth = _worth([row for one in differences for row in one])
    return Scatter(float(np.sqrt(squares / freedom)), worth, worth * freedom)


def _differences_deg(group: Sequence[Recording]) -> Array:
    """What is left of each run without what all of a group share, (runs, samples)."""
    time_s = _common_s(group)
    u = np.array([one.command_at(one.time_s[0] + time_s) for one in group])
    y = np.array([np.interp(time_s, _since(one), one.angle_deg) for one in group])
    u, y = (rows - rows.mean(axis=1, keepdims=True) for rows in (u, y))
    error = y - float(np.sum(u * y)) / max(float(np.sum(u * u)), 1e-300) * u
    return np.asarray(error - error.mean(axis=0))


def _worth(rows: Sequence[Array]) -> float:
    """How many independent samples one of ``rows`` (samples,) each is worth in a mean square.

    One over the sum of the squared correlation at all lags, up to where chance could have made it
    (Bayley and Hammersley, Supplement to the JRSS 8 (1946) 184).
    """
    lags = min(row.size for row in rows) - 1
    sums = np.sum([lagged_sums(row, row, lags) for row in rows], axis=0)
    pairs = np.sum([row.size - np.arange(lags + 1) for row in rows], axis=0)
    correlation = sums / pairs * (pairs[0] / max(sums[0], 1e-300))
    by_chance = np.abs(correlation) <= 2.0 / np.sqrt(pairs)
    end = int(np.argmax(by_chance)) if by_chance.any() else lags + 1
    return float(1.0 / (1.0 + 2.0 * np.sum(correlation[1:end] ** 2)))


def run_floor(recordings: Sequence[Recording]) -> tuple[Scatter | None, list[str]]:
    """The scatter of runs with the same command, where it may be the floor, and a sentence.

    Runs that differ by more than ``LARGEST`` of the range differ in more than chance: a gain, a
    load or a supply that was changed between them is physics, and not the floor.
    """
    scatter = run_scatter(recordings)
    if scatter is None or scatter.rms_deg < SAME_RUN_DEG:
        return None, []
    names = ", ".join(one.name for group in _groups(recordings) for one in group)
    differ = f"{names} have the same command and differ by {degrees(scatter.rms_deg)} rms"
    moved = max(one.moved_range_deg for one in recordings)
    if scatter.rms_deg > LARGEST * moved:
        return None, [
            f"{differ}, more than {100.0 * LARGEST:.0f} % of the moved range: what was changed "
            f"between them? For gain or load set relative_gain or relative_load in recording.toml"
        ]
    return scatter, [
        f"{differ}, noise included: where that is more than the noise, it is the floor"
    ]


def _runs(judged: Sequence[Judged]) -> list[tuple[tuple[str, ...], Array]]:
    """Errors (runs, samples) of each group of recordings with the same command, gain and load."""
    error = {id(one.recording): one.error_deg for one in judged}
    found = []
    for group in _groups([one.recording for one in judged]):
        time_s = _common_s(group)
        errors = [np.interp(time_s, _since(one), error[id(one)]) for one in group]
        found.append((tuple(one.name for one in group), np.array(errors)))
    return found


def _groups(recordings: Sequence[Recording]) -> list[list[Recording]]:
    """Those with the same command, gain and load, and enough samples in common."""
    left = list(recordings)
    found = []
    while left:
        first = left.pop(0)
        alike = [one for one in left if _same(first, one)]
        left = [one for one in left if all(one is not other for other in alike)]
        if alike and _common_s([first, *alike]).size >= FEWEST:
            found.append([first, *alike])
    return found


def _common_s(group: Sequence[Recording]) -> Array:
    """The times of the first of some runs, from its first sample on, that all of them have."""
    time_s = _since(group[0])
    return np.asarray(time_s[time_s <= min(_since(one)[-1] for one in group)])


def _same(first: Recording, second: Recording) -> bool:
    """True for the same command, sampled from the first sample of each on, and equal conditions."""
    alike = ("relative_gain", "relative_load", "side")
    if any(getattr(first, name) != getattr(second, name) for name in alike):
        return False
    since = _since(first)
    since = since[since <= _since(second)[-1]]
    if since.size < FEWEST:
        return False
    mine, other = (one.command_at(one.time_s[0] + since) for one in (first, second))
    return bool(np.sqrt(np.mean((mine - other) ** 2)) <= SAME_COMMAND * max(np.ptp(mine), 1e-12))


def _since(recording: Recording) -> Array:
    return np.asarray(recording.time_s - recording.time_s[0])
