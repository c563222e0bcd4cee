"""Where in a text file a table begins: lines above its header, comments, the row of units."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servosight.models.io.tables._dates import date_kind
from servosight.models.io.tables._header_units import is_unit, split_unit

COMMENT = "#"
QUOTE = '"'
_MARKS = (",", ";", "\t")
_LONGEST_PREAMBLE = 200
_SAMPLE = 20
"""Lines by which the width of a table is judged."""


@dataclass(frozen=True)
class Layout:
    """The lines of a table, counted from 1: that of its header first; and notes on others."""

    numbers: tuple[int, ...]
    notes: tuple[str, ...] = ()


def layout_of(path: Path, lines: Sequence[str]) -> Layout:
    """Where the header and the rows are; what is skipped is said in the notes.

    Of lines that begin with ``#`` the last above the numbers is the header where it names each
    column. Lines above a header that has as many fields as the rows are skipped where they have
    another number of them.
    """
    filled = [number for number, line in enumerate(lines, 1) if line.strip()]
    comments = [number for number in filled if lines[number - 1].lstrip().startswith(COMMENT)]
    skipped = set(comments)
    numbers = [number for number in filled if number not in skipped] if comments else filled
    above = [number for number in comments if numbers and number < numbers[0]]
    if above and _names_columns(lines[above[-1] - 1], lines[numbers[0] - 1]):
        skipped.remove(above[-1])
        numbers.insert(0, above[-1])
    notes = []
    if skipped:
        begin = "begin" if len(skipped) > 1 else "begins"
        notes.append(_note(path, sorted(skipped), f" that {begin} with {COMMENT}"))
    start = _header_place([lines[number - 1] for number in numbers])
    if start:
        notes.append(_note(path, numbers[:start], f" above the header in row {numbers[start]}"))
    return Layout(tuple(numbers[start:]), tuple(notes))


def with_units(names: Sequence[str], cells: Sequence[str]) -> tuple[str, ...] | None:
    """Names with the units that the row below them holds; None where that is no row of units.

    >>> with_units(["t", "pos", "mode"], ["s", "(rad)", ""])
    ('t (s)', 'pos (rad)', 'mode')
    >>> with_units(["t", "pos"], ["0.0", "rad"]), with_units(["t", "pos"], ["a", "b"])
    (None, None)
    """
    units = [cell.strip().strip("()[]").strip() for cell in cells]
    if any(is_number(one) for one in units) or not any(map(is_unit, units)):
        return None
    return tuple(
        f"{name} ({unit})" if unit and split_unit(name)[1] is None else name
        for name, unit in zip(names, units, strict=True)
    )


def delimiter_of(header: str, row: str) -> str:
    """The separator that cuts header and first row into as many fields; else what the header has.

    A comma where there is none.
    """
    for mark in (*_MARKS, " "):
        if len(_split(header, mark)) == len(_split(row, mark)) > 1:
            return mark
    return next((mark for mark in _MARKS if mark in header), ",")


def is_number(text: str) -> bool:
    """True for what Python reads as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _header_place(rows: Sequence[str]) -> int:
    """How many rows stand above the header; 0 where it is the first, or cannot be found."""
    middle = len(rows) // 2
    body = rows[middle : middle + _SAMPLE]
    for mark in (*_MARKS, " "):
        widths = {len(_split(row, mark)) for row in body}
        if len(widths) != 1 or max(widths) < 2:
            continue
        (width,) = widths
        top = [len(_split(row, mark)) == width for row in rows[:_LONGEST_PREAMBLE]]
        place = top.index(True) if True in top else 0
        while place + 1 < len(top) and not (top[place] and top[place + 1]):
            place += 1
        # A header with a name too few stands above numbers: the first of them is no header.
        header = place + 1 < len(top) and not _holds_numbers(_split(rows[place], mark))
        return place if header else 0
    return 0


def _holds_numbers(cells: Sequence[str]) -> bool:
    filled = [cell.strip() for cell in cells if cell.strip()]
    return any(is_number(cell.replace(",", ".")) or date_kind(cell) for cell in filled)


def _names_columns(comment: str, row: str) -> bool:
    """True where a comment has a name for each number of the first row, as numpy writes it."""
    header = comment.lstrip().removeprefix(COMMENT).strip()
    mark = delimiter_of(header, row)
    cells, names = _split(row, mark), _split(header, mark)
    return len(cells) == len(names) > 1 and all(is_number(one) or date_kind(one) for one in cells)


def _split(row: str, mark: str) -> list[str]:
    if mark == " ":
        return row.split()
    if QUOTE in row:
        try:
            return next(csv.reader([row], delimiter=mark))
        except csv.Error:  # longer than a field may be: the reader of the rows refuses it
            pass
    return row.split(mark)


def _note(path: Path, skipped: Sequence[int], which: str) -> str:
    count = f"{len(skipped):,} line{'s' * (len(skipped) > 1)}"
    are = "are" if len(skipped) > 1 else "is"
    return f"{path}: {count}{which} {are} skipped, the first is row {skipped[0]}"
