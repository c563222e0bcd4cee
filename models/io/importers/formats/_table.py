"""Tables in text files with headers of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servosight.models.core import Mask, Recording
from servosight.models.io._csv import Sheet, read_sheet
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import Request

_NO = ("0", "0.0", "false", "off", "no")


def recognises(path: Path, start: bytes) -> bool:
    """Whatever is text; the last to be asked."""
    return not path.is_dir() and b"\0" not in start


def read_table(path: Path, request: Request) -> Recording:
    """Read a table whose columns the request names; servosight's own names need no naming."""
    sheet = read_sheet(path)
    table = Columns(
        f"{path}, row 1",
        sheet.header,
        lambda name: sheet.columns([name])[:, 0],
        lambda size: sheet.numbers,
        flags=lambda name: _flags(sheet, name),
    )
    raw, notes = raw_columns(path, table, request)
    return assemble(path, raw, request, {"source": source_of(path, "csv", raw)}, notes)


def _flags(sheet: Sheet, name: str) -> Mask:
    """False where a column says no, in whichever way."""
    place = sheet.header.index(name)
    cells = (row.split(sheet.delimiter)[place].strip().lower() for row in sheet.rows)
    return np.array([cell not in _NO for cell in cells])
