"""What the user says about a log, and how its columns become seconds and degrees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, Recording, plain_name
from servosight.models.io._recording import Streams, recording_of
from servosight.models.io._series import DEGREES, SECONDS, Series
from servosight.models.io._settings import RecordingSettings

QUANTITIES = ("time", "command", "angle", "sigma")
PULSE = "us"


@dataclass(frozen=True)
class Column:
    """A column's name in the log and its unit, None where the user gave none."""

    name: str
    unit: str | None = None


@dataclass(frozen=True)
class Request:
    """The user's words about a log.

    ``columns`` by quantity (time, command, angle, sigma); ``unit`` holds for what has no unit of
    its own; ``unit_scale`` is how many degrees show one unit of an output that is no angle;
    ``deg_per_us`` and ``neutral_us`` convert a command given as pulse width.
    """

    columns: Mapping[str, Column] = field(default_factory=dict)
    unit: str | None = None
    unit_scale: float | None = None
    deg_per_us: float | None = None
    neutral_us: float | None = None


@dataclass(frozen=True)
class Imported:
    """A recording and what the user should know about how it was read."""

    recording: Recording
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Raw:
    """A quantity as it stands in the log: its column, unit, numbers (rows,) and their places."""

    column: str
    unit: str
    values: Array
    rows: Sequence[int]
    word: str


def parse_map(words: Sequence[str]) -> dict[str, Column]:
    """``["time=t:ms", "angle=pos:rad"]`` as columns by quantity."""
    columns: dict[str, Column] = {}
    for word in words:
        quantity, equals, place = word.partition("=")
        name, colon, unit = place.rpartition(":")
        if not colon:
            name, unit = place, ""
        if not equals or not name or quantity not in QUANTITIES:
            raise InputError(
                f"--map {word}: expected one of {', '.join(QUANTITIES)}, = and a column, with its "
                f"unit where it is not s or deg; write it like --map angle=pos:rad"
            )
        if quantity in columns:
            raise InputError(f"--map {word}: {quantity} is mapped twice, expected once; remove one")
        columns[quantity] = Column(name, unit or None)
    return columns


def unit_of(quantity: str, column: Column, request: Request) -> str:
    """The unit of a quantity: as mapped, as the column's name ends, as the log's other columns."""
    ending = column.name.rpartition("_")[2]
    known = (*SECONDS,) if quantity == "time" else (*DEGREES, PULSE)
    if column.unit is not None:
        return column.unit
    if ending != column.name and ending in known:
        return ending
    if quantity == "time":
        return "s"
    return request.unit or "deg"


def assemble(
    path: Path, raw: Mapping[str, Raw], request: Request, details: Mapping[str, Any]
) -> Recording:
    """Convert, check and join the quantities of one log with rows in common."""
    table: dict[str, Any] = dict(details)
    foreign = {
        one.unit
        for name, one in raw.items()
        if name != "time" and one.unit not in (*DEGREES, PULSE)
    }
    if foreign and request.unit_scale is not None:
        table = {"unit": sorted(foreign)[0], "unit_scale": request.unit_scale, **table}
    series = {
        name: Series(
            path, one.column, one.values, _converted(path, name, one, request), one.rows, one.word
        )
        for name, one in raw.items()
    }
    streams = Streams(
        series["time"], series["command"], series["time"], series["angle"], series.get("sigma")
    )
    settings = RecordingSettings(unit_scale=request.unit_scale or 1.0, details=table)
    return recording_of(plain_name(path.stem), streams, settings)


def _converted(path: Path, quantity: str, raw: Raw, request: Request) -> Array:
    with np.errstate(over="ignore", invalid="ignore"):
        if quantity == "time":
            if raw.unit not in SECONDS:
                raise _unknown(path, raw, tuple(SECONDS))
            return raw.values / SECONDS[raw.unit]
        if raw.unit == PULSE and quantity == "command":
            if request.deg_per_us is None or request.neutral_us is None:
                raise InputError(
                    f"{path}: column {raw.column} is a pulse width, expected the servo's scale; "
                    f"give --deg-per-us and --neutral-us"
                )
            return (raw.values - request.neutral_us) * request.deg_per_us
        if raw.unit in DEGREES:
            return raw.values * DEGREES[raw.unit]
        if request.unit_scale is None or raw.unit == PULSE:
            raise _unknown(path, raw, tuple(DEGREES))
        scale = abs(request.unit_scale) if quantity == "sigma" else request.unit_scale
        return raw.values * scale


def _unknown(path: Path, raw: Raw, known: tuple[str, ...]) -> InputError:
    return InputError(
        f"{path}: column {raw.column} has the unit {raw.unit!r}, expected {', '.join(known)}; "
        f"write --map ...={raw.column}:{known[0]}, or for an output that is no angle give "
        f"--unit-scale, the degrees that show one {raw.unit}"
    )
