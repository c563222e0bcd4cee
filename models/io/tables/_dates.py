"""Time stamps that are calendar dates, as ISO 8601 writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError

_DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:?\d\d")


def is_date(cell: str) -> bool:
    """True for a date with a time of day.

    >>> is_date("2026-03-01T12:00:00.25Z"), is_date("20260301"), is_date("0.25")
    (True, False, False)
    """
    return _DATE.match(cell.strip()) is not None


def seconds_of(path: Path, name: str, cells: Sequence[str], rows: Sequence[int]) -> Array:
    """Dates as seconds since 1970 (rows,), in UTC where they name no zone.

    InputError for a cell that is none.
    """
    found = np.empty(len(cells))
    for place, (row, cell) in enumerate(zip(rows, cells, strict=True)):
        try:
            date = datetime.fromisoformat(cell.strip())
        except ValueError:
            raise InputError(
                f"{path}, row {row}: column {name} is {cell.strip()[:40]!r}, expected a date such "
                f"as 2026-03-01T12:00:00.250 as in the rows before; correct the cell or delete "
                f"the row"
            ) from None
        found[place] = (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
    return found
