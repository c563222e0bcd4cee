"""Where a table's motor has torque, and what is kept of it: a load that falls follows no servo."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.models.core import InputError, Mask, runs_of
from servosight.models.io.tables import Sheet, several

_PLAIN_NAMES = ("torqueenable", "torqueenabled")
"""Columns that say whether the motor has torque, without path, joint, case and separators."""
_LABEL = re.compile(r"\[[^\[\]]*\]$")
_NO = ("false", "off", "no")


def power_columns(names: Sequence[str]) -> list[str]:
    """The columns that say whether a motor has torque.

    >>> power_columns(["t", "Torque Enable", "/servo.torque_enabled[elbow]", "torque"])
    ['Torque Enable', '/servo.torque_enabled[elbow]']
    """
    return [name for name in names if _plain(name) in _PLAIN_NAMES]


def power_column(names: Sequence[str], angle: str = "") -> str | None:
    """The column that says whether the motor has torque; None where there is none for it.

    Of several it is that of the angle's joint, or else of the angle's topic.

    >>> power_column(["torque_enable[pan]", "torque_enable[elbow]"], "position[elbow]")
    'torque_enable[elbow]'
    """
    found = power_columns(names)
    own = [name for name in found if _label(name) in ("", _label(angle))]
    beside = [name for name in own if name.rpartition(".")[0] == angle.rpartition(".")[0]]
    best = own if len(own) == 1 else beside
    return best[0] if len(best) == 1 else None


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", _LABEL.sub("", name).rpartition(".")[2]).lower()


def _label(name: str) -> str:
    """The joint or place in brackets behind a name, with them."""
    found = _LABEL.search(name)
    return found[0] if found else ""


def switched_on(sheet: Sheet, column: str) -> Mask:
    """False in each row whose cell says no, in whichever way, (rows,)."""
    return np.array([not _says_no(cell.strip().lower()) for cell in sheet.cells(column)], bool)


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
    words = several(word)
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
    runs = runs_of(flags)
    if not len(runs):
        return 0, 0
    start, stop = runs[np.argmax(runs[:, 1] - runs[:, 0])].tolist()
    return start, stop
