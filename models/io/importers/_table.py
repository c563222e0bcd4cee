"""CSV logs with headers of their own."""

from __future__ import annotations

from pathlib import Path

from servosight.models.core import InputError, plain_name
from servosight.models.io._csv import Sheet, read_sheet
from servosight.models.io._series import DEGREES, SECONDS
from servosight.models.io.importers._request import (
    Column,
    Imported,
    Raw,
    Request,
    assemble,
    unit_of,
)


def read_table(path: Path, request: Request) -> Imported:
    """Read a table whose columns the request names; servosight's own names need no naming."""
    sheet = read_sheet(path)
    raw: dict[str, Raw] = {}
    for quantity in ("time", "command", "angle", "sigma"):
        column = _column(sheet, quantity, request)
        if column is not None:
            values = sheet.columns([column.name])[:, 0]
            unit = unit_of(quantity, column, request)
            raw[quantity] = Raw(column.name, unit, values, sheet.numbers, "row")
    source = {
        "name": plain_name(path.name),
        "format": "csv",
        **{f"{quantity}_column": one.column for quantity, one in raw.items()},
    }
    return Imported(assemble(path, raw, request, {"source": source}))


def _column(sheet: Sheet, quantity: str, request: Request) -> Column | None:
    column = request.columns.get(quantity)
    if column is None:
        units = SECONDS if quantity == "time" else (*DEGREES, "us")
        own = [f"{quantity}_{unit}" for unit in units if f"{quantity}_{unit}" in sheet.header]
        if own:
            return Column(own[0])
        if quantity == "sigma":
            return None
        raise InputError(
            f"{sheet.path}, row 1: no column is known to be the {quantity}; expected --map "
            f"{quantity}=COLUMN with one of {_names(sheet)}"
        )
    if column.name in sheet.header:
        return column
    whole = f"{column.name}:{column.unit}"
    if whole in sheet.header:  # the name itself has a colon in it
        return Column(whole)
    raise InputError(
        f"{sheet.path}, row 1: no column {column.name}, expected one of {_names(sheet)}; correct "
        f"--map {quantity}={column.name}"
    )


def _names(sheet: Sheet) -> str:
    return ", ".join(sheet.header)[:300]
