"""Time stamps that are calendar dates or times of day, as ISO 8601 writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime, time
from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError

_DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:?\d\d")
_CLOCK = re.compile(r"\d\d:\d\d:\d\d")
DATES = "dates, read as seconds since 1970, in UTC where they name no zone"
CLOCKS = "times of day, read as seconds since midnight"


def date_kind(cell: str) -> str | None:
    """What a stamp is and how it is read: ``DATES``, ``CLOCKS``, or None where it is neither.

    >>> date_kind("2026-03-01T12:00:00.25Z") == DATES, date_kind("12:00:00,250") == CLOCKS
    (True, True)
    >>> date_kind("20260301"), date_kind("0.25")
    (None, None)
    """
    for pattern, kind in ((_DATE, DATES), (_CLOCK, CLOCKS)):
        if pattern.match(cell.strip()):
            return kind
    return None


def seconds_of(path: Path, name: str, cells: Sequence[str], rows: Sequence[int]) -> Array:
    """Dates as seconds since 1970 (rows,), in UTC where they name no zone; times since midnight.

    InputError for a cell that is none of the first one's kind.
    """
    read = _date if date_kind(cells[0]) == DATES else _clock
    found = np.empty(len(cells))
    for place, (row, cell) in enumerate(zip(rows, cells, strict=True)):
        try:
            found[place] = read(cell.strip())
        except ValueError:
            raise InputError(
                f"{path}, row {row}: column {name} is {cell.strip()[:40]!r}, expected a date or "
                f"time such as {cells[0].strip()[:40]!r} in the rows before; correct the cell or "
                f"delete the row"
            ) from None
    return found


def _date(text: str) -> float:
    date = datetime.fromisoformat(text)
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def _clock(text: str) -> float:
    at = time.fromisoformat(text)
    return at.hour * 3600.0 + at.minute * 60.0 + at.second + at.microsecond / 1e6
