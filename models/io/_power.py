"""Where a table's motor has torque, and what is kept of it: a load that falls follows no servo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.models.core import InputError, Mask
from servosight.models.io._csv import Sheet

_COLUMNS = ("torque_enable", "torque_enabled")
"""Columns that say whether the motor has torque."""
_NO = ("false", "off", "no")


def power_column(names: Sequence[str]) -> str | None:
    """The column that says whether the motor has torque."""
    return next((name for name in names if name.strip().lower() in _COLUMNS), None)


def switched_on(sheet: Sheet, column: str) -> Mask:
    """False in each row whose cell says no, in whichever way, (rows,)."""
    place = sheet.header.index(column)
    cells = (row.split(sheet.delimiter)[place].strip().lower() for row in sheet.rows)
    return np.array([not _says_no(cell) for cell in cells], dtype=bool)


def powered_sheet(sheet: Sheet) -> tuple[Sheet, tuple[str, ...]]:
    """The rows of the longest stretch with torque, and a note if that is not all of them."""
    column = power_column(sheet.header)
    if column is None:
        return sheet, ()
    start, stop, notes = powered_run(
        sheet.path, switched_on(sheet, column), column, sheet.numbers, "row"
    )
    kept = replace(sheet, rows=sheet.rows[start:stop], numbers=sheet.numbers[start:stop])
    return kept, notes


def powered_run(
    path: Path, on: Mask, column: str, rows: Sequence[int], word: str
) -> tuple[int, int, tuple[str, ...]]:
    """Start and end (exclusive) of the longest stretch in which ``on`` (rows,), and a note.

    There is none where that is everything. ``rows`` are the places in the file as ``word`` counts
    them, ``column`` is where the log says so. InputError where the motor is never on.
    """
    start, stop = _longest_run(on)
    words = "entries" if word == "entry" else f"{word}s"
    if stop - start == on.size:
        return start, stop, ()
    if start == stop:
        raise InputError(
            f"{path}: column {column} is true in none of the {on.size} {words}, expected a "
            f"servo that is switched on; choose another log"
        )
    return (
        start,
        stop,
        (
            f"{path}: {column} is false in {int(np.sum(~on)):,} of {on.size:,} {words}, where the "
            f"servo does not hold the load; only {words} {rows[start]} to {rows[stop - 1]} "
            f"are kept",
        ),
    )


def _says_no(cell: str) -> bool:
    try:
        return float(cell) == 0.0
    except ValueError:
        return cell in _NO


def _longest_run(flags: Mask) -> tuple[int, int]:
    """Start and end (exclusive) of the longest stretch of True; the first on a tie."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    if starts.size == 0:
        return 0, 0
    best = int(np.argmax(stops - starts))
    return int(starts[best]), int(stops[best])
