"""Units of a log's columns: as the user gives them, as the header writes them, or asked for."""

from __future__ import annotations

import re
from pathlib import Path

from servosight.models.core import InputError
from servosight.models.io._series import DEGREES, SECONDS
from servosight.models.io.importers._request import PULSE, SIGNALS, Column, Request

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


def unit_of(path: Path | str, quantity: str, column: Column, request: Request) -> str:
    """The unit of a quantity: as mapped, as its header has it, as given for all; else InputError.

    A time without any is in seconds: a clock that is not is refused for its rate.
    """
    if column.unit is not None:
        return spelled(column.unit)
    unit = split_unit(column.name)[1]
    if unit is not None:
        return unit
    if quantity == "time":
        return "s"
    if quantity in SIGNALS:
        raise InputError(
            f"{path}: column {column.name} for the {quantity} has no unit, expected one such as N, "
            f"Nm, A or V; write it behind the column, as in {quantity}={column.name}:N"
        )
    if request.unit is not None:
        return spelled(request.unit)
    raise InputError(
        f"{path}: column {column.name} for the {quantity} has no unit, expected one of "
        f"{', '.join(DEGREES)}; write it behind the column, as in {quantity}={column.name}:rad, or "
        f"give one for all columns, as in --unit rad"
    )


_KNOWN = frozenset((*SECONDS, *DEGREES, PULSE))
