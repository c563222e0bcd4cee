"""Time stamps of a host: a few that run back are left out, samples that share one are joined."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, Mask
from servosight.models.io.importers._gaps import kept
from servosight.models.io.tables import FEWEST_SAMPLES, Series, several

MOST_RUNNING_BACK = 0.01
"""The share of a log's rows that may be left out for their stamps; with more the clock is wrong."""


def in_order(series: Mapping[str, Series]) -> tuple[dict[str, Series], list[str]]:
    """The series without rows whose stamps do not rise with the others', and a sentence on each.

    Where more than ``MOST_RUNNING_BACK`` of a clock's rows do not, all stay, to be refused.
    """
    notes = []
    found = dict(series)
    for clock, names in _clocks(series).items():
        time = series[clock]
        wrong = ~_rising(time.values)
        count = int(wrong.sum())
        if not 0 < count <= MOST_RUNNING_BACK * wrong.size:
            continue
        found |= {name: kept(series[name], ~wrong) for name in names}
        words = several(time.word)
        were = "were" if count > 1 else "was"
        notes.append(
            f"{time.path}: {count:,} of {wrong.size:,} {words}, where {time.name} jumps away from "
            f"the clock, {were} left out, the first is {time.word} "
            f"{time.rows[int(np.argmax(wrong))]}"
        )
    return found, notes


def one_a_stamp(series: Mapping[str, Series]) -> tuple[dict[str, Series], list[str]]:
    """Samples of one stamp averaged, of commands the last kept; and a sentence where there are.

    InputError where the clock is so coarse that too few samples are left.
    """
    notes = []
    found = dict(series)
    for clock, names in _clocks(series).items():
        time = series[clock]
        begins = np.concatenate([[True], np.diff(time.values) != 0.0])
        if np.all(begins) or not np.all(np.isfinite(time.values)):
            continue
        firsts = np.flatnonzero(begins)
        counts = np.diff(np.append(firsts, begins.size))
        if clock == "time" and firsts.size < FEWEST_SAMPLES <= begins.size:
            raise InputError(
                f"{time.path}: column {time.name} has {begins.size:,} {several(time.word)} and "
                f"{firsts.size} different stamps, expected at least {FEWEST_SAMPLES}; map a column "
                f"whose clock is finer"
            )
        found |= {name: _merged(series[name], name, firsts, counts) for name in names}
        if clock == "time":
            many = int(counts[counts > 1].sum())
            first_s = time.values[firsts[np.argmax(counts > 1)]]
            notes.append(
                f"{time.path}: {many:,} of {begins.size:,} samples share their time stamp with "
                f"others; each group became its mean, the first at {first_s:.6g} s"
            )
    return found, notes


def _clocks(series: Mapping[str, Series]) -> dict[str, list[str]]:
    """Each clock and what has its rows, itself included."""
    if "command_time" not in series:
        return {"time": list(series)}
    own = [name for name in series if name in ("command_time", "command")]
    return {"time": [name for name in series if name not in own], "command_time": own}


def _rising(stamps: Array) -> Mask:
    """The longest run of stamps that never falls, (rows,); all where one is no number.

    A single stamp too late then costs that row, not all behind it.
    """
    if not np.all(np.isfinite(stamps)) or np.all(np.diff(stamps) >= 0.0):
        return np.ones(stamps.size, dtype=bool)
    values = stamps.tolist()
    smallest: list[float] = []  # the last stamp of the best run of each length
    rows: list[int] = []
    before: list[int] = []
    for row, value in enumerate(values):
        length = bisect_right(smallest, value)
        before.append(rows[length - 1] if length else -1)
        smallest[length : length + 1] = [value]
        rows[length : length + 1] = [row]
    kept = np.zeros(stamps.size, dtype=bool)
    row = rows[-1]
    while row >= 0:
        kept[row] = True
        row = before[row]
    return kept


def _merged(one: Series, name: str, firsts: Any, counts: Any) -> Series:
    lasts = firsts + counts - 1
    means: list[Array] = []
    for values in (one.raw, one.values):
        if name in ("time", "command_time", "command"):
            means.append(values[lasts])
        elif name == "sigma":
            means.append(np.sqrt(np.add.reduceat(values**2, firsts)) / counts)
        else:
            means.append(np.add.reduceat(values, firsts) / counts)
    return replace(kept(one, firsts), raw=means[0], values=means[1])
