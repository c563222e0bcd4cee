"""Recordings out: a folder that is written completely or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from servosight.models.core import Array, Recording, Stream, new_folder, write_text
from servosight.models.io._settings import FORMAT
from servosight.models.io._shared_error import SHARED_FILE, write_shared
from servosight.models.io.tables import table_text

FILES = ("recording.toml", "command.csv", "angle.csv", "horn.csv", "signals.csv", SHARED_FILE)
"""What ``save_recording`` writes."""


def save_recording(
    recording: Recording,
    folder: Path,
    *,
    extra: Mapping[str, Any] | None = None,
    force: bool = False,
) -> None:
    """Write a recording's folder, completely or not at all; ``extra``: further keys of its TOML.

    A folder that is not empty is replaced only with ``force``, and only if it holds nothing but a
    recording's files. Reading it gives the same numbers to the last bit (with a ``unit_scale`` in
    the details, to the last digit). The video stays where it is.
    """
    table: dict[str, Any] = {"format": FORMAT, **recording.details, **(extra or {})}
    recording = recording.shifted(float(table.get("latency_s", 0.0)))
    for key in ("command_hold", "command_frame_s", "command_frame_at_s"):
        table.pop(key, None)  # the command is written as it acts
    table["hold"] = recording.hold
    for key in ("relative_gain", "relative_load"):
        if getattr(recording, key) != 1.0 or key in table or "reference" in table:
            table[key] = getattr(recording, key)
    table.pop("angle_of", None)
    if recording.side == "sensor":
        table["angle_of"] = "sensor"
    if recording.offset_sigma_s > 0.0 or "offset_sigma_s" in table:
        table["offset_sigma_s"] = recording.offset_sigma_s
    if recording.notes:
        table["import_notes"] = list(recording.notes)
    if recording.exposure_s > 0.0:
        table["camera"] = {**table.get("camera", {}), "exposure_s": recording.exposure_s}
    scale = float(table.get("unit_scale", 1.0))
    command = table_text(
        ("time_s", "command_deg"), (recording.command_time_s, recording.command_deg / scale)
    )
    with new_folder(folder, FILES, force=force) as fresh:
        write_text(fresh / "recording.toml", tomli_w.dumps(table))
        write_text(fresh / "command.csv", command)
        surface = Stream(recording.time_s, recording.angle_deg, recording.sigma_deg)
        for file, stream in (("angle.csv", surface), ("horn.csv", recording.horn)):
            if stream is None:
                continue
            sigma = None if stream.sigma_deg is None else stream.sigma_deg / abs(scale)
            write_angle(fresh / file, stream.time_s, stream.angle_deg / scale, sigma)
        if recording.signals is not None:
            names, values = zip(*recording.signals.values.items(), strict=True)
            columns = (recording.signals.time_s, *values)
            write_text(fresh / "signals.csv", table_text(("time_s", *names), columns))
        write_shared(fresh, recording.time_s, recording.shared_deg, scale)


def write_angle(path: Path, time_s: Array, angle_deg: Array, sigma_deg: Array | None) -> None:
    """Write ``time_s,angle_deg[,sigma_deg]`` (samples,), completely or not at all."""
    write_text(path, angle_text(time_s, angle_deg, sigma_deg))


def angle_text(time_s: Array, angle_deg: Array, sigma_deg: Array | None) -> str:
    """``time_s,angle_deg[,sigma_deg]`` (samples,) as CSV."""
    header = ["time_s", "angle_deg"]
    columns = [time_s, angle_deg]
    if sigma_deg is not None:
        header.append("sigma_deg")
        columns.append(sigma_deg)
    return table_text(header, columns)
