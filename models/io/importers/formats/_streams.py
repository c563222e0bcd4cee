"""Logs of messages: each column has the stamps of its own topic."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from servosight.models.core import Array, InputError, Recording, column_map, did_you_mean
from servosight.models.io._power import power_column
from servosight.models.io._signals import overlooked
from servosight.models.io.importers._apart import Extract, Parser, extract
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import (
    Columns,
    powered,
    source_of,
    unknown_columns,
)
from servosight.models.io.importers._raw import Raw
from servosight.models.io.importers._request import COMMAND_TIME, Request
from servosight.models.io.importers._units import units_of
from servosight.models.io.tables import SIGNALS, listed, split_path

Notes: TypeAlias = tuple[str, ...]


def read_streams(path: Path, parser: Parser, form: str, request: Request) -> Recording:
    """A recording from columns that the request names; time is that of each column's messages."""
    for quantity in {"time", COMMAND_TIME} & set(request.columns):
        raise InputError(
            f"{path}: {column_map(quantity, 'COLUMN')} does not apply to {parser.kind}, whose "
            f"messages have stamps; expected command and angle alone, so leave it out"
        )
    wanted = [column.name for column in request.columns.values()]
    found = extract(path, parser, wanted)
    raw: dict[str, Raw] = {}
    missing = [name for name in ("command", "angle") if name not in request.columns]
    if missing:
        raise unknown_columns(path, _table(path, found), missing, request)
    units, assumed = units_of(path, request.columns, request, split_path, found.units)
    for quantity, column in request.columns.items():
        if column.name not in found.columns:
            near = did_you_mean(column.name, found.names)
            raise InputError(
                f"{path}: no column {column.name}{near}, expected one of {listed(found.names)}; "
                f"correct {column_map(quantity, column.name)}"
            )
        values = found.columns[column.name]
        raw[quantity] = Raw(column.name, units[quantity], values, range(values.size), "message")
        if quantity in ("command", "angle"):
            clock = "time" if quantity == "angle" else "command_time"
            raw[clock] = _stamps(raw[quantity], found, column.name)
    for name in SIGNALS:
        if name in raw:
            raw[name] = _latest(raw[name], found.times_s[raw[name].column], raw["time"])
    details: dict[str, Any] = {"source": {**source_of(path, form, raw), **found.facts}}
    used = [one.column for one in raw.values()]
    raw, cut = _powered(path, raw, found)
    told = (f"{path}: {note}" for note in found.notes)
    every = (*told, *assumed, *overlooked(path, found.names, used, split_path), *cut)
    return assemble(path, raw, request, details, every)


def _table(path: Path, found: Extract) -> Columns:
    """What messages hold, with the units that they are defined in."""

    def split(name: str) -> tuple[str, str | None]:
        bare, unit = split_path(name)
        return bare, unit or found.units.get(name)

    return Columns(str(path), found.names, found.columns.__getitem__, range, "message", split=split)


def _powered(path: Path, raw: dict[str, Raw], found: Extract) -> tuple[dict[str, Raw], Notes]:
    """What was measured while the motor had torque; the command, on its own clock, stays whole."""
    power = power_column(list(found.columns), raw["angle"].column)
    if power is None:
        return raw, ()
    flags = replace(raw["angle"], column=power, values=found.columns[power])
    on = _latest(flags, found.times_s[power], raw["time"]).values != 0.0
    return powered(path, raw, on, power)


def _latest(raw: Raw, times_s: Array, clock: Raw) -> Raw:
    """The latest value at each of the angle's stamps; before the first one that one."""
    latest = np.searchsorted(times_s, clock.values, side="right") - 1
    return replace(raw, values=raw.values[np.maximum(latest, 0)], rows=clock.rows)


def _stamps(raw: Raw, found: Extract, name: str) -> Raw:
    return replace(raw, column=f"stamp of {name}", unit="s", values=np.asarray(found.times_s[name]))
