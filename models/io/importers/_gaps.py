"""Rows of a log without an angle or a command: a read that failed, or a stream of another rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from servosight.models.io.tables import Series, several


def without_gaps(series: Mapping[str, Series]) -> tuple[dict[str, Series], list[str]]:
    """The series with a number in each row, and a sentence on each that had none somewhere.

    A row without an angle is left out, with all else that has its clock. A command stays in force
    until the next one, so where it has gaps its other rows become a stream with a clock of its own.
    """
    found = dict(series)
    notes = []
    command = series["command"]
    told = ~np.isnan(command.raw)
    if not np.all(told):
        clock = series.get("command_time", series["time"])
        found |= {"command": kept(command, told), "command_time": kept(clock, told)}
        notes.append(_note(command, told, "where the command before holds on"))
    angle = series["angle"]
    read = ~np.isnan(angle.raw)
    if not np.all(read):
        if "command_time" not in found:
            found["command_time"] = series["time"]
        own = [name for name in series if name not in ("command", "command_time")]
        found |= {name: kept(series[name], read) for name in own}
        notes.append(_note(angle, read, "and were left out"))
    return found, notes


def kept(one: Series, rows: Any) -> Series:
    """Some rows of a series, by a mask or by their places."""
    places = np.arange(one.raw.size)[rows]
    names = [one.rows[place] for place in places.tolist()]
    return replace(one, raw=one.raw[places], values=one.values[places], rows=names)


def _note(one: Series, there: Any, what: str) -> str:
    words = several(one.word)
    first = one.rows[int(np.argmin(there))]
    return (
        f"{one.path}: {int(np.sum(~there)):,} of {there.size:,} {words} have no number in "
        f"{one.name}, {what}; the first is {one.word} {first}"
    )
