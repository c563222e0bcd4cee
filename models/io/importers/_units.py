"""Units of a log's columns: as the user gives them, as the header writes them, or asked for."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from servosight.models.core import InputError, column_map, either
from servosight.models.io._series import DEGREES, SECONDS, SIGNALS
from servosight.models.io.importers._request import PULSE, Column, Request

_SPELLINGS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millis", "milliseconds"), "ms"),
    **dict.fromkeys(("µs", "μs", "usec", "micros", "microseconds"), "us"),
    **dict.fromkeys(("nsec", "nanos", "nanoseconds"), "ns"),
    **dict.fromkeys(("°", "degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("turn", "turns", "revolution", "revolutions"), "rev"),
}
"""Other spellings of the units in ``SECONDS`` and ``DEGREES``."""
_BRACKETS = re.compile(r"(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")


def spelled(unit: str) -> str:
    """A unit as servosight spells it; one that it does not know stays as it is.

    >>> spelled("Degrees"), spelled("counts")
    ('deg', 'counts')
    """
    word = unit.strip()
    return _SPELLINGS.get(word.lower(), word.lower() if word.lower() in _KNOWN else word)


def split_unit(header: str) -> tuple[str, str | None]:
    """A column's name and the unit that its header writes behind it, None where it writes none.

    Whatever is in brackets is a unit, unless it is a number; behind an underscore or a slash only
    a unit that is known.

    >>> split_unit("pos (rad)"), split_unit("t [ms]"), split_unit("goal_rad"), split_unit("time/ms")
    (('pos', 'rad'), ('t', 'ms'), ('goal', 'rad'), ('time', 'ms'))
    >>> split_unit("pos (counts)"), split_unit("arm/pos"), split_unit("joint[2]")
    (('pos', 'counts'), ('arm/pos', None), ('joint[2]', None))
    """
    found = _BRACKETS.fullmatch(header.strip())
    if found:
        unit = (found["round"] if found["square"] is None else found["square"]).strip()
        if unit and not unit.isdigit():
            return found["name"], spelled(unit)
        return header, None
    for mark in "_/":
        name, _, unit = header.rpartition(mark)
        if name and spelled(unit) in _KNOWN:
            return name, spelled(unit)
    return header, None


def units_of(
    path: Path | str, columns: Mapping[str, Column], request: Request
) -> tuple[dict[str, str], tuple[str, ...]]:
    """The unit of each quantity, as mapped, as its header has it or as given for all; and notes.

    Where no angle of the log has a unit, degrees are assumed, which a note says; where only some
    have none, InputError. A time without any is in seconds: a clock that is not is refused for its
    rate.
    """
    units = {name: _given(name, column, request) for name, column in columns.items()}
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
    note = (
        f"{path}: no unit is given for {names}, read in degrees; {either('unit', '--unit')} names "
        f"another"
    )
    return {name: unit or "deg" for name, unit in units.items()}, (note,) if silent else ()


def _given(quantity: str, column: Column, request: Request) -> str | None:
    if column.unit is not None:
        return spelled(column.unit)
    unit = split_unit(column.name)[1]
    if unit is None and quantity == "time":
        return "s"
    if unit is None and quantity in ANGLES and request.unit is not None:
        return spelled(request.unit)
    return unit


ANGLES = ("command", "angle", "sigma")
"""Quantities with the unit of an angle."""
_KNOWN = frozenset((*SECONDS, *DEGREES, PULSE))
