"""Recordings from arrays and data frames, checked as files are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Hold, InputError, Recording
from servosight.models.io._recording import Streams, recording_of
from servosight.models.io._series import Series
from servosight.models.io._settings import RecordingSettings
from servosight.models.io.importers import Column, Raw, Request, assemble, unit_of


def recording_from_arrays(
    *,
    time_s: Any,
    angle_deg: Any,
    command_deg: Any,
    command_time_s: Any = None,
    sigma_deg: Any = None,
    hold: Hold = "zero",
    exposure_s: float = 0.0,
    name: str = "arrays",
) -> Recording:
    """See :meth:`servosight.Recording.from_arrays`."""
    if hold not in ("zero", "linear"):
        raise InputError(f"hold is {hold!r}, expected 'zero' or 'linear'; give one of them")
    own_clock = command_time_s is not None
    time, angle = _series(name, "time_s", time_s), _series(name, "angle_deg", angle_deg)
    command_time = _series(name, "command_time_s", command_time_s) if own_clock else time
    command = _series(name, "command_deg", command_deg)
    sigma = None if sigma_deg is None else _series(name, "sigma_deg", sigma_deg)
    for clock, column in ((time, angle), (time, sigma), (command_time, command)):
        if column is not None and column.raw.size != clock.raw.size:
            raise InputError(
                f"{name}: {column.name} has {column.raw.size} values and {clock.name} "
                f"{clock.raw.size}, expected as many of both; give command_time_s where the "
                f"command has rows of its own"
            )
    streams = Streams(command_time, command, time, angle, sigma)
    return recording_of(name, streams, RecordingSettings(hold=hold, exposure_s=float(exposure_s)))


def recording_from_frame(
    frame: Any,
    *,
    time: str = "time_s",
    angle: str = "angle_deg",
    command: str = "command_deg",
    sigma: str | None = None,
    unit: str | None = None,
    time_unit: str | None = None,
    name: str = "frame",
) -> Recording:
    """See :meth:`servosight.Recording.from_frame`."""
    names = {"time": time, "angle": angle, "command": command, "sigma": sigma}
    request = Request(unit=unit)
    raw = {}
    for quantity, column in names.items():
        if column is None:
            continue
        if column not in list(frame.columns):
            raise InputError(
                f"{name}: no column {column!r}, expected one of "
                f"{', '.join(map(str, frame.columns))}; name the {quantity}'s column"
            )
        given = time_unit if quantity == "time" else None
        series = _series(name, column, frame[column])
        unit_here = unit_of(quantity, Column(column, given), request)
        raw[quantity] = Raw(column, unit_here, series.raw, series.rows, "row")
    return assemble(Path(name), raw, request, {})


def _series(name: str, label: str, values: Any) -> Series:
    """One column of numbers; InputError where it is none."""
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
    return Series(Path(name), label, array, array, range(array.size), "index")
