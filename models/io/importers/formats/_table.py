"""Tables in text files with headers of their own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from servosight.models.core import Array, InputError, Recording, plain_name
from servosight.models.io._power import switched_on
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import COMMAND_TIME, Request
from servosight.models.io.tables import SIGNALS, date_kind, read_sheet, seconds_of, with_gaps


def recognises(path: Path, start: bytes) -> bool:
    """Whatever is text; the last to be asked."""
    return not path.is_dir() and b"\0" not in start


def read_table(path: Path, request: Request) -> Recording:
    """Read a table whose columns the request names; servosight's own names need no naming."""
    if request.command is None:
        raw, notes = raw_columns(path, _columns(path), request)
        return assemble(path, raw, request, {"source": source_of(path, "csv", raw)}, notes)
    answer = ("time", "angle", "sigma", *SIGNALS)
    raw, notes = raw_columns(path, _columns(path), request, answer)
    own = {"time": request.columns[COMMAND_TIME]} if COMMAND_TIME in request.columns else {}
    told = replace(request, columns={**request.columns, **own})
    sent, more = raw_columns(request.command, _columns(request.command), told, ("time", "command"))
    raw["command_time"] = replace(sent["time"], path=request.command)
    raw["command"] = replace(sent["command"], path=request.command)
    source = {**source_of(path, "csv", raw), "command_name": plain_name(request.command.name)}
    return assemble(path, raw, request, {"source": source}, (*notes, *more))


def _columns(path: Path) -> Columns:
    sheet = read_sheet(path)
    first = sheet.rows[0].split(sheet.delimiter) if sheet.rows else []
    kinds = {name: date_kind(cell) for name, cell in zip(sheet.header, first, strict=False)}
    dated = {name: kind for name, kind in kinds.items() if kind is not None}

    def numbers(name: str) -> Array:
        if name in dated:
            return seconds_of(path, name, sheet.cells(name), sheet.numbers)
        try:
            return sheet.columns([name])[:, 0]
        except InputError:
            return with_gaps(sheet, name).columns([name])[:, 0]

    return Columns(
        sheet.place,
        sheet.header,
        numbers,
        lambda size: sheet.numbers,
        flags=lambda name: switched_on(sheet, name),
        notes=sheet.notes,
        dated=dated,
    )
