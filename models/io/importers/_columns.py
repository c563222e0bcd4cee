"""Which columns of a table are time, command, angle and sigma: as mapped, else by their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, Mask, plain_name
from servosight.models.io._series import DEGREES, SECONDS
from servosight.models.io.importers._assemble import Raw
from servosight.models.io.importers._request import PULSE, QUANTITIES, SIGNALS, Column, Request
from servosight.models.io.importers._units import split_unit, units_of

_LONGEST_LIST = 300
_POWER = ("torque_enable", "torque_enabled")
"""Columns that say whether the motor has torque."""


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


def chosen_columns(
    table: Columns, request: Request, quantities: Sequence[str] = (*QUANTITIES, *SIGNALS)
) -> dict[str, Column]:
    """The column of each quantity; InputError where one is missing.

    A sigma need not be there, and signals are looked for only where the request names them.
    """
    asked = [name for name in quantities if name not in SIGNALS or name in request.columns]
    found = {quantity: _column(table, quantity, request) for quantity in asked}
    return {quantity: column for quantity, column in found.items() if column is not None}


def raw_columns(
    path: Path,
    table: Columns,
    request: Request,
    quantities: Sequence[str] = (*QUANTITIES, *SIGNALS),
) -> tuple[dict[str, Raw], tuple[str, ...]]:
    """The quantities of a table with one time for all of them, as they stand in it, and notes.

    What the table holds while the motor has no torque is left out: a load that falls freely follows
    no model of a servo.
    """
    columns = chosen_columns(table, request, quantities)
    units, notes = units_of(path, columns, request)
    raw: dict[str, Raw] = {}
    for quantity, column in columns.items():
        values = table.numbers(column.name)
        raw[quantity] = Raw(
            column.name, units[quantity], values, table.rows(values.size), table.word
        )
    power = power_column(table.names)
    if power is None:
        return raw, notes
    on = table.flags(power) if table.flags is not None else table.numbers(power) != 0.0
    raw, cut = powered(path, raw, on, power)
    return raw, (*notes, *cut)


def power_column(names: Sequence[str]) -> str | None:
    """The column that says whether the motor has torque."""
    return next((name for name in names if name.strip().lower() in _POWER), None)


def powered(
    path: Path, raw: Mapping[str, Raw], on: Mask, column: str
) -> tuple[dict[str, Raw], tuple[str, ...]]:
    """The quantities over the longest stretch in which ``on`` (rows,), and a note if it is not all.

    ``column`` is where the log says so.
    """
    start, stop = _longest_run(on)
    if stop - start == on.size:
        return dict(raw), ()
    one = next(iter(raw.values()))
    words = "entries" if one.word == "entry" else f"{one.word}s"
    if start == stop:
        raise InputError(
            f"{path}: column {column} is true in none of the {on.size} {words}, expected a "
            f"servo that is switched on; choose another log"
        )
    kept = {
        name: replace(part, values=part.values[start:stop], rows=part.rows[start:stop])
        for name, part in raw.items()
    }
    return kept, (
        f"{path}: {column} is false in {int(np.sum(~on)):,} of {on.size:,} {words}, where the "
        f"servo does not hold the load; only {words} {one.rows[start]} to {one.rows[stop - 1]} "
        f"are kept",
    )


def _longest_run(flags: Mask) -> tuple[int, int]:
    """Start and end (exclusive) of the longest stretch of True; the first on a tie."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    if starts.size == 0:
        return 0, 0
    best = int(np.argmax(stops - starts))
    return int(starts[best]), int(stops[best])


def source_of(path: Path, form: str, raw: Mapping[str, Raw]) -> dict[str, Any]:
    """What recording.toml keeps of where a recording came from."""
    columns = {f"{quantity}_column": one.column for quantity, one in raw.items()}
    return {"name": plain_name(path.name), "format": form, **columns}


def listed(names: Sequence[str]) -> str:
    """Names for a message, cut where they are many."""
    return ", ".join(names)[:_LONGEST_LIST] or "(none)"


def _column(table: Columns, quantity: str, request: Request) -> Column | None:
    column = request.columns.get(quantity)
    if column is None:
        return _by_name(table, quantity)
    if column.name in table.names:
        return column
    whole = f"{column.name}:{column.unit}"
    if whole in table.names:  # the name itself has a colon in it
        return Column(whole)
    named = [name for name in table.names if split_unit(name)[0] == column.name]
    if len(named) == 1:
        return Column(named[0], column.unit)
    raise InputError(
        f"{table.place}: no column {column.name}, expected one of {listed(table.names)}; correct "
        f"--map {quantity}={column.name}"
    )


def _by_name(table: Columns, quantity: str) -> Column | None:
    """The column that is called as the quantity is, with a unit."""
    units = SECONDS if quantity == "time" else (*DEGREES, PULSE)
    for name in table.names:
        bare, unit = split_unit(name)
        if bare.lower() == quantity and unit in units:
            return Column(name)
    if quantity == "sigma":
        return None
    raise InputError(
        f"{table.place}: no column is known to be the {quantity}; expected --map {quantity}=COLUMN "
        f"with one of {listed(table.names)}"
    )
