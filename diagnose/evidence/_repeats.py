"""How much of an error repeats where the command does: the rest is the servo's own floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals import Judged
from servosight.identify.problem import command_periods, period_table
from servosight.models.core import Array, Recording, degrees

SAME_COMMAND = 0.01
"""Commands of two runs are the same where they differ by less than this share of the range, rms."""
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


def _runs(judged: Sequence[Judged]) -> list[tuple[tuple[str, ...], Array]]:
    """Errors (runs, samples) of each group of recordings with the same command, gain and load."""
    left = list(judged)
    found = []
    while left:
        first = left.pop(0)
        alike = [one for one in left if _same(first.recording, one.recording)]
        left = [one for one in left if all(one is not other for other in alike)]
        if not alike:
            continue
        group = [first, *alike]
        time_s = _since(first.recording)
        time_s = time_s[time_s <= min(_since(one.recording)[-1] for one in group)]
        if time_s.size >= FEWEST:
            errors = [np.interp(time_s, _since(one.recording), one.error_deg) for one in group]
            found.append((tuple(one.recording.name for one in group), np.array(errors)))
    return found


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
