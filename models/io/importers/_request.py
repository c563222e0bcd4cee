"""What the user says about a log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from servosight.models.core import InputError, Side, column_map, did_you_mean
from servosight.models.io.tables import SIGNALS

QUANTITIES = ("time", "command", "angle", "sigma")
COMMAND_TIME = "command_time"
"""The clock of a command that has rows of its own."""
ALL = (*QUANTITIES, COMMAND_TIME, *SIGNALS)


@dataclass(frozen=True)
class Column:
    """A column's name in the log and its unit, None where the user gave none."""

    name: str
    unit: str | None = None


@dataclass(frozen=True)
class Request:
    """The user's words about a log.

    ``columns`` by quantity, one of ``ALL``; ``unit`` holds
    for what has no unit of its own; ``unit_scale`` is how many degrees show one unit of an output
    that is no angle;
    ``deg_per_us`` and ``neutral_us`` convert a command given as pulse width; ``part`` is which
    episode of a data set, from 0. ``command`` is a second log on the same clock, in which the
    command stands. ``angle_of`` is what measured the angle, None where the format or, failing that,
    the surface is to be taken.
    """

    columns: Mapping[str, Column] = field(default_factory=dict)
    unit: str | None = None
    unit_scale: float | None = None
    deg_per_us: float | None = None
    neutral_us: float | None = None
    part: int = 0
    command: Path | None = None
    angle_of: Side | None = None


def check_distinct(name: str, columns: Mapping[str, Column]) -> None:
    """InputError where command and angle are one column of the log ``name``."""
    command, angle = columns.get("command"), columns.get("angle")
    if command is not None and angle is not None and command.name == angle.name:
        raise InputError(
            f"{name}: column {angle.name} is mapped to command and angle both, expected a column "
            f"for each; correct one of the two"
        )


def parse_map(words: Sequence[str]) -> dict[str, Column]:
    """``["time=t:ms", "angle=pos:rad"]`` as columns by quantity."""
    columns: dict[str, Column] = {}
    for word in words:
        quantity, equals, place = word.partition("=")
        name, colon, unit = place.rpartition(":")
        if not colon:
            name, unit = place, ""
        if equals and name and quantity not in ALL:
            raise InputError(
                f"columns: {quantity} in {word} is no quantity{did_you_mean(quantity, ALL)}, "
                f"expected one of {', '.join(ALL)}; correct the name before the equals sign"
            )
        if not equals or not name:
            raise InputError(
                f"columns: {word} maps none, expected one of "
                f"{', '.join(ALL)} and a column, with its unit where its "
                f"header has none; write it like {column_map('angle', 'pos:rad')}"
            )
        if quantity in columns:
            raise InputError(f"columns: {quantity} is mapped twice, expected once; remove {word}")
        columns[quantity] = Column(name, unit or None)
    return columns
