"""Recordings from arrays and data frames, checked as files are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Hold, InputError, Recording
from servosight.models.io._recording import Streams, recording_of
from servosight.models.io._settings import RecordingSettings
from servosight.models.io.importers import Column, Raw, Request, assemble, check_distinct, units_of
from servosight.models.io.tables import Series, check_angle, check_finite, check_time

_OPTIONAL = ("command_time_s", "sigma_deg")


def recording_from_arrays(
    name: str, arrays: Mapping[str, Any], hold: Hold, exposure_s: float
) -> Recording:
    """What :meth:`servosight.Recording.from_arrays` does; ``arrays`` by its arguments' names."""
    if hold not in ("zero", "linear"):
        raise InputError(f"hold is {hold!r}, expected 'zero' or 'linear'; give one of them")
    sigma_deg = arrays["sigma_deg"]
    if sigma_deg is not None and np.ndim(sigma_deg) == 0:
        arrays = {**arrays, "sigma_deg": np.full(np.shape(arrays["angle_deg"]), sigma_deg)}
    found = {
        key: _series(name, key, one)
        for key, one in arrays.items()
        if one is not None or key not in _OPTIONAL
    }
    time, angle, command = found["time_s"], found["angle_deg"], found["command_deg"]
    command_time, sigma = found.get("command_time_s", time), found.get("sigma_deg")
    for clock, column in ((time, angle), (time, sigma), (command_time, command)):
        if column is not None and column.raw.size != clock.raw.size:
            raise InputError(
                f"{name}: {column.name} has {column.raw.size} values and {clock.name} "
                f"{clock.raw.size}, expected as many of both; give command_time_s where the "
                f"command has rows of its own"
            )
    streams = Streams(command_time, command, time, angle, sigma)
    return recording_of(name, streams, RecordingSettings(hold=hold, exposure_s=float(exposure_s)))


def command_from_arrays(name: str, time_s: Any, command_deg: Any) -> tuple[Array, Array]:
    """Times [s] and values [deg] of a command's rows, (rows,) each.

    Raises InputError where they are no numbers, differ in length or the time does not rise.
    """
    time, command = _series(name, "time_s", time_s), _series(name, "command_deg", command_deg)
    if time.raw.size != command.raw.size or time.raw.size < 2:
        raise InputError(
            f"{name}: time_s has {time.raw.size} values and command_deg {command.raw.size}, "
            f"expected as many of both, and two or more; give one value for each time"
        )
    for column in (time, command):
        check_finite(column)
    check_time(time)
    check_angle(command)
    return time.values, command.values


def recording_from_frame(
    name: str,
    frame: Any,
    columns: Mapping[str, str | None],
    unit: str | None,
    time_unit: str | None,
) -> Recording:
    """What :meth:`servosight.Recording.from_frame` does; ``columns`` by quantity."""
    request = Request(unit=unit)
    known = _column_names(name, frame)
    chosen = {
        quantity: Column(column, time_unit if quantity == "time" else None)
        for quantity, column in columns.items()
        if column is not None
    }
    check_distinct(name, chosen)
    for quantity, column in chosen.items():
        if column.name not in known:
            raise InputError(
                f"{name}: no column {column.name!r}, expected one of "
                f"{', '.join(map(str, known))}; name the {quantity}'s column"
            )
    units, notes = units_of(name, chosen, request)
    raw = {}
    for quantity, column in chosen.items():
        series = _series(name, column.name, frame[column.name])
        check_finite(series)  # as in a recording's files: only a log has reads that failed
        raw[quantity] = Raw(column.name, units[quantity], series.raw, series.rows, "row")
    return assemble(Path(name), raw, request, {}, notes)


def _column_names(name: str, frame: Any) -> list[Any]:
    """Those of a data frame, or the keys of a mapping; InputError where it is neither."""
    if isinstance(frame, Mapping):
        return list(frame)
    if not hasattr(frame, "columns"):
        raise InputError(
            f"{name}: is a {type(frame).__name__}, expected a pandas or Polars data frame or a "
            f"mapping of columns; for arrays there is Recording.from_arrays"
        )
    return list(frame.columns)


def _series(name: str, label: str, values: Any) -> Series:
    """One column of numbers; InputError where it is none, or one of them is masked or complex."""
    if np.iscomplexobj(values):
        raise InputError(f"{name}: {label} is complex, expected real numbers; take its real part")
    try:
        array: Array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(
            f"{name}: {label} is no array of numbers, expected 1-D numbers; convert it first"
        ) from None
    if array.ndim != 1:
        raise InputError(
            f"{name}: {label} has the shape {array.shape}, expected one dimension; give one column"
        )
    if isinstance(values, np.ma.MaskedArray) and np.any(values.mask):
        raise InputError(
            f"{name}, index {np.argmax(values.mask)}: {label} is masked, expected a number for "
            f"each sample; leave out of every array what is masked in one, as in "
            f"{label}[~{label}.mask]"
        )
    return Series(Path(name), label, array, array, range(array.size), "index")
