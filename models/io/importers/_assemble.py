"""The quantities of a log, as they stand in it, become a recording in seconds and degrees."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import (
    Array,
    InputError,
    Recording,
    Side,
    Signals,
    column_map,
    either,
    plain_name,
)
from servosight.models.io._recording import Streams, recording_of
from servosight.models.io._settings import RecordingSettings
from servosight.models.io._signals import signal_name
from servosight.models.io.importers._cadence import cadence_notes, stamp_sigma_s
from servosight.models.io.importers._counters import unwrapped
from servosight.models.io.importers._gaps import without_gaps
from servosight.models.io.importers._raw import Raw
from servosight.models.io.importers._request import Request
from servosight.models.io.importers._stamps import in_order, one_a_stamp
from servosight.models.io.importers._turns import continuous
from servosight.models.io.tables import (
    DEGREES,
    PULSE,
    SECONDS,
    SIGNALS,
    Series,
    check_enough,
    check_finite,
)

_OWN_READING = re.compile(r"present[\s_]?position|joint_?states?|observation\.state", re.IGNORECASE)
"""In a column's name: the servo's own sensor measured it, as Dynamixel, ROS and LeRobot call it."""
_OF_ANGLE_AND_COMMAND = ("time", "command_time", "command", "angle", "sigma")


# Long by the fields of a recording: each is converted and checked in a line or two.
def assemble(
    path: Path,
    raw: Mapping[str, Raw],
    request: Request,
    details: Mapping[str, Any],
    notes: Sequence[str] = (),
    side: Side = "surface",
) -> Recording:
    """Convert, check and join the quantities of one log.

    ``raw`` by quantity: time, command, angle, where known sigma, and ``command_time`` where the
    command has rows of its own; whatever else is in it becomes a signal. ``notes`` are sentences
    that the user should read; the recording keeps them. ``side`` is what measured the angle, unless
    the request says it.
    """
    table: dict[str, Any] = dict(details)
    raw, wraps = unwrapped(path, raw)
    foreign = {
        one.unit
        for name, one in raw.items()
        if name in ("command", "angle", "sigma") and one.unit not in (*DEGREES, PULSE)
    }
    if len(foreign) > 1 and request.unit_scale is not None:
        raise InputError(
            f"{path}: command and angle have the units {' and '.join(sorted(foreign))}, expected "
            f"one unit for {either('unit_scale', '--unit-scale')}; convert one of them to degrees "
            f"first"
        )
    if foreign and request.unit_scale is not None:
        table = {"unit": sorted(foreign)[0], "unit_scale": request.unit_scale, **table}
    series = {
        name: Series(
            one.path or path,
            one.column,
            one.values,
            _converted(one.path or path, name, one, request),
            one.rows,
            one.word,
        )
        for name, one in raw.items()
    }
    _check_sizes(path, series)
    series, missing = without_gaps(series)
    check_enough(series["angle"])
    series, dropped = in_order(series)
    series, joined = continuous(series)
    sigma_s = stamp_sigma_s(series["time"])
    series, merged = one_a_stamp(series)
    streams = Streams(
        series.get("command_time", series["time"]),
        series["command"],
        series["time"],
        series["angle"],
        series.get("sigma"),
    )
    settings = RecordingSettings(unit_scale=request.unit_scale or 1.0, details=table)
    recording = replace(
        recording_of(plain_name(path.stem), streams, settings),
        side=request.angle_of or side,
        offset_sigma_s=sigma_s,
    )
    uneven = cadence_notes(streams.time, "command_time" in series)
    signals = {
        signal_name(name, raw[name].unit) if name in SIGNALS else name: one
        for name, one in series.items()
        if name not in _OF_ANGLE_AND_COMMAND
    }
    doubts = _side_doubts(path, raw["angle"], side) if request.angle_of is None else []
    every = (*notes, *doubts, *wraps, *missing, *dropped, *joined, *merged, *uneven)
    if not signals:
        return replace(recording, notes=every)
    for one in signals.values():
        check_finite(one)
    kept = Signals(series["time"].values, {name: one.values for name, one in signals.items()})
    return replace(recording, notes=every, signals=kept)


def _side_doubts(path: Path, angle: Raw, side: Side) -> list[str]:
    """A sentence where an angle is taken as the surface's and named like a servo's own reading."""
    if side == "sensor" or not _OWN_READING.search(angle.column):
        return []
    return [
        f"{path}: {angle.column} is taken as the angle of the surface, and its name is that of a "
        f"servo's own reading; if it is one, give "
        f"{either('angle_of=sensor', '--angle-of sensor')}, so that a diagnosis holds k at 1 and "
        f"tries nothing behind the sensor; else the same with surface"
    ]


def _check_sizes(path: Path, series: Mapping[str, Series]) -> None:
    for name, one in series.items():
        clock = series["time"]
        if name in ("command", "command_time"):
            clock = series.get("command_time", clock)
        if one.raw.size != clock.raw.size:
            own = name == "command" and clock is series["time"]
            remedy = f", or its own clock by {column_map('command_time', 'COLUMN')}" if own else ""
            raise InputError(
                f"{path}: column {one.name} has {one.raw.size} values and {clock.name} "
                f"{clock.raw.size}, expected the same number; map another one{remedy}"
            )


def _converted(path: Path, quantity: str, raw: Raw, request: Request) -> Array:
    with np.errstate(over="ignore", invalid="ignore"):
        if quantity.endswith("time"):
            if raw.unit not in SECONDS:
                raise _unknown(path, quantity, raw, tuple(SECONDS))
            return raw.values / SECONDS[raw.unit]
        if quantity not in _OF_ANGLE_AND_COMMAND:
            return raw.values
        if raw.unit == PULSE and quantity == "command":
            if request.deg_per_us is None or request.neutral_us is None:
                raise InputError(
                    f"{path}: column {raw.column} is a pulse width, expected the servo's scale; "
                    f"give {either('deg_per_us and neutral_us', '--deg-per-us and --neutral-us')}"
                )
            return (raw.values - request.neutral_us) * request.deg_per_us
        if raw.unit in DEGREES:
            return raw.values * DEGREES[raw.unit]
        if request.unit_scale is None or raw.unit == PULSE:
            raise _unknown(path, quantity, raw, tuple(DEGREES))
        scale = abs(request.unit_scale) if quantity == "sigma" else request.unit_scale
        return raw.values * scale


def _unknown(path: Path, quantity: str, raw: Raw, known: tuple[str, ...]) -> InputError:
    message = (
        f"{path}: column {raw.column} has the unit {raw.unit!r}, expected {', '.join(known)}; "
        f"write {column_map(quantity, f'{raw.column}:{known[0]}')}"
    )
    if quantity.endswith("time"):
        return InputError(f"{message}, or whichever of them it is")
    return InputError(
        f"{message} if it is that, or for an output that is no angle give "
        f"{either('unit_scale', '--unit-scale')}, the degrees that show one {raw.unit}"
    )
