"""Which columns of a table are time, command, angle and sigma: as mapped, else by their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import (
    Array,
    InputError,
    Mask,
    column_map,
    column_maps,
    did_you_mean,
    plain_name,
)
from servosight.models.io._power import power_column, powered_run
from servosight.models.io._signals import overlooked, signal_columns
from servosight.models.io.importers._raw import Raw
from servosight.models.io.importers._request import ALL, COMMAND_TIME, QUANTITIES, Column, Request
from servosight.models.io.importers._units import units_of
from servosight.models.io.tables import (
    DEGREES,
    PULSE,
    SECONDS,
    SIGNALS,
    Split,
    likely_columns,
    listed,
    split_unit,
    with_unit,
)

_ANY, _ANY_UNIT = "COLUMN", "COLUMN:UNIT"


@dataclass(frozen=True)
class Columns:
    """A table whose columns are read on demand.

    ``place`` stands in messages ("log.csv, row 1"), ``names`` are its columns, ``numbers`` gives
    those of one (rows,), ``rows`` their places in the file as ``word`` counts them.
    """

    place: str
    names: Sequence[str]
    numbers: Callable[[str], Array]
    rows: Callable[[int], Sequence[int]]
    word: str = "row"
    flags: Callable[[str], Mask] | None = None
    """A column of yes and no, (rows,); where there is none, every number but 0 is a yes."""
    split: Split = split_unit
    notes: tuple[str, ...] = ()
    dated: Mapping[str, str] = field(default_factory=dict)
    """Columns of dates or times of day, whose numbers are seconds, and how they are read."""


def chosen_columns(
    path: Path,
    table: Columns,
    request: Request,
    quantities: Sequence[str] = ALL,
) -> dict[str, Column]:
    """The column of each quantity; InputError where one is missing.

    A sigma need not be there, nor a signal.
    """
    asked = [name for name in quantities if name in QUANTITIES or name in request.columns]
    found = {quantity: _column(table, quantity, request) for quantity in asked}
    missing = [name for name, one in found.items() if one is None and name != "sigma"]
    if missing:
        raise unknown_columns(path, table, missing, request)
    for name, column in signal_columns(table.names, table.split).items():
        quantity, _, unit = name.partition("_")
        if quantity in quantities and quantity not in found:
            found[quantity] = Column(column, unit)
    return {quantity: column for quantity, column in found.items() if column is not None}


def raw_columns(
    path: Path,
    table: Columns,
    request: Request,
    quantities: Sequence[str] = ALL,
) -> tuple[dict[str, Raw], tuple[str, ...]]:
    """The quantities of a table with one time for all of them, as they stand in it, and notes.

    What the table holds while the motor has no torque is left out: a load that falls freely follows
    no model of a servo.
    """
    columns = chosen_columns(path, table, request, quantities)
    units, notes = units_of(path, columns, request, table.split)
    dates = [
        f"{path}: column {one.name} holds {table.dated[one.name]}"
        for one in columns.values()
        if one.name in table.dated
    ]
    notes = (*table.notes, *dates, *notes)
    raw: dict[str, Raw] = {}
    for quantity, column in columns.items():
        values = _numbers(table, quantity, column, request)
        if values is None:
            notes = (*notes, f"{path}: column {column.name} is not kept, as not every row has one")
            continue
        raw[quantity] = Raw(
            column.name, units[quantity], values, table.rows(values.size), table.word
        )
    if "disturbance" in quantities:
        used = [column.name for column in columns.values()]
        notes = (*notes, *overlooked(path, table.names, used, table.split))
    angle = columns["angle"].name if "angle" in columns else ""
    power = power_column(table.names, angle)
    if power is None:
        return raw, notes
    on = table.flags(power) if table.flags is not None else table.numbers(power) != 0.0
    raw, cut = powered(path, raw, on, power)
    return raw, (*notes, *cut)


def _numbers(table: Columns, quantity: str, column: Column, request: Request) -> Array | None:
    """A column's numbers; None for a signal that nobody asked for and that has gaps."""
    optional = quantity in SIGNALS and quantity not in (*request.columns, "disturbance")
    try:
        values = table.numbers(column.name)
    except InputError:
        if optional:
            return None
        raise
    return None if optional and not np.all(np.isfinite(values)) else values


def powered(
    path: Path, raw: Mapping[str, Raw], on: Mask, column: str
) -> tuple[dict[str, Raw], tuple[str, ...]]:
    """The quantities over the longest stretch in which ``on`` (rows,), and a note if it is not all.

    ``column`` is where the log says so. A command with a clock of its own stays whole.
    """
    own = ("command", COMMAND_TIME) if COMMAND_TIME in raw else ()
    measured = {name: part for name, part in raw.items() if name not in own}
    for part in measured.values():
        if part.values.size != on.size:
            raise InputError(
                f"{path}: column {part.column} has {part.values.size} values and {column} "
                f"{on.size}, expected the same number; map another one"
            )
    one = next(iter(measured.values()))
    start, stop, notes = powered_run(path, on, column, one.rows, one.word)
    kept = {
        name: replace(part, values=part.values[start:stop], rows=part.rows[start:stop])
        for name, part in measured.items()
    }
    return {**raw, **kept}, notes


def source_of(path: Path, form: str, raw: Mapping[str, Raw]) -> dict[str, Any]:
    """What recording.toml keeps of where a recording came from."""
    columns = {f"{quantity}_column": one.column for quantity, one in raw.items()}
    return {"name": plain_name(path.name), "format": form, **columns}


def unknown_columns(
    path: Path, table: Columns, missing: Sequence[str], request: Request
) -> InputError:
    """What to map for the ``missing`` quantities: columns with their names, of which the unit alone
    is not known, else those whose names say what they may be."""
    silent = {
        quantity: name
        for quantity in missing
        for name in table.names
        if table.split(name) == (name, None) and name.lower() == quantity
    }
    likely = {**likely_columns(table.names, table.split), **silent}
    given = {name: f"{one.name}:{one.unit or ''}" for name, one in request.columns.items()}
    maps = {name: one.removesuffix(":") for name, one in given.items()}
    with_units = request.unit or any(table.split(name)[1] for name in table.names)
    any_name = _ANY if with_units else _ANY_UNIT
    maps |= {
        name: with_unit(name, likely[name], table.split, request.unit)
        if name in likely
        else any_name
        for name in missing
    }
    write = f"write {column_maps(maps, None if request.command else path, request.unit)}"
    if any(maps[name] != likely.get(name, any_name) for name in missing):
        write += ", with other units where they count those"
    if any_name in maps.values():
        unit = " and its unit" if any_name == _ANY_UNIT else ""
        write += f", and the name of a column{unit} for {any_name}"
    if missing[0] not in silent:
        by_name = "if they are what their names say, " if likely.keys() & set(missing) else ""
        return InputError(
            f"{table.place}: no column among {listed(table.names)} is known to be the "
            f"{' or the '.join(missing)}, expected a map; {by_name}{write}"
        )
    columns, have = ("columns", "have") if len(silent) > 1 else ("column", "has")
    return InputError(
        f"{table.place}: {columns} {', '.join(silent.values())} {have} no unit, expected one in "
        f"the header or in the map; {write}"
    )


def _column(table: Columns, quantity: str, request: Request) -> Column | None:
    column = request.columns.get(quantity)
    found = _by_name(table, quantity, request) if column is None else _mapped(table, column)
    if found is None and column is not None:
        near = did_you_mean(column.name, table.names)
        own = quantity == "time" and table.place.startswith(f"{request.command}, ")
        raise InputError(
            f"{table.place}: no column {column.name}{near}, expected one of {listed(table.names)}; "
            f"correct {column_map(COMMAND_TIME if own else quantity, column.name)}"
        )
    return Column(found.name, "s") if found is not None and found.name in table.dated else found


def _mapped(table: Columns, column: Column) -> Column | None:
    """The column that a map names, by its whole name or by that without the unit."""
    if column.name in table.names:
        return column
    whole = f"{column.name}:{column.unit}"
    if whole in table.names:  # the name itself has a colon in it
        return Column(whole)
    named = [name for name in table.names if table.split(name)[0] == column.name]
    return Column(named[0], column.unit) if len(named) == 1 else None


def _by_name(table: Columns, quantity: str, request: Request) -> Column | None:
    """The column that is called as the quantity is, with a unit, or one that is given for all."""
    units = SECONDS if quantity == "time" else (*DEGREES, PULSE)
    for name in table.names:
        bare, unit = table.split(name)
        given = request.unit is not None and quantity != "time"
        known = unit in units or (unit is None and (given or name in table.dated))
        if bare.lower() == quantity and known:
            return Column(name)
    return None
