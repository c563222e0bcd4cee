"""Units of a log's columns: as the user gives them, as the header writes them, or asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from servosight.models.core import InputError, column_map, either
from servosight.models.io.importers._request import Column, Request
from servosight.models.io.tables import DEGREES, SIGNALS, Split, signal_unit, spelled, split_unit

ANGLES = ("command", "angle", "sigma")
"""Quantities with the unit of an angle."""


def units_of(
    path: Path | str,
    columns: Mapping[str, Column],
    request: Request,
    split: Split = split_unit,
    defined: Mapping[str, str] | None = None,
) -> tuple[dict[str, str], tuple[str, ...]]:
    """The unit of each quantity, as mapped, as its header has it or as given for all; and notes.

    Else it is that which ``defined`` has for its column, by the definition of a message. Where no
    angle of the log has a unit, degrees are assumed, which a note says; where only some have none,
    InputError. A time without any is in seconds: a clock that is not is refused for its rate.
    ``split`` tells name and unit of a column apart.
    """
    units = {name: _given(name, column, request, split) for name, column in columns.items()}
    notes = []
    for name, column in columns.items():
        unit = (defined or {}).get(column.name)
        if name in ANGLES and units[name] is None and unit is not None:
            units[name] = unit
            notes.append(
                f"{path}: {column.name} is read in {unit}, as its message is defined; "
                f"{column_map(name, f'{column.name}:deg')} if it is in degrees"
            )
    for quantity in SIGNALS:
        if quantity in units and units[quantity] is None:
            raise InputError(
                f"{path}: column {columns[quantity].name} for the {quantity} has no unit, expected "
                f"one such as N, Nm, A or V; write it behind the column, as in "
                f"{quantity}={columns[quantity].name}:N"
            )
    silent = [name for name in ANGLES if name in units and units[name] is None]
    if silent and any(units.get(name) is not None for name in ANGLES):
        name = columns[silent[0]].name
        raise InputError(
            f"{path}: column {name} for the {silent[0]} has no unit while others have one, "
            f"expected one of {', '.join(DEGREES)}; write it behind the column, as in "
            f"{column_map(silent[0], f'{name}:rad')}, or give one for all columns, as in "
            f"{either('unit=rad', '--unit rad')}"
        )
    names = " and ".join(dict.fromkeys(columns[name].name for name in silent))
    if silent:
        notes.append(
            f"{path}: no unit is given for {names}, read in degrees; {either('unit', '--unit')} "
            f"names another"
        )
    return {name: unit or "deg" for name, unit in units.items()}, tuple(notes)


def _given(quantity: str, column: Column, request: Request, split: Split) -> str | None:
    if column.unit is not None:
        return spelled(column.unit)
    if quantity in SIGNALS:
        return signal_unit(column.name, split)
    unit = split(column.name)[1]
    if unit is None and quantity.endswith("time"):
        return "s"
    if unit is None and quantity in ANGLES and request.unit is not None:
        return spelled(request.unit)
    return unit
