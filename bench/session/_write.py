"""The recording of a run: command, frames and what the servo reported, on the command's clock."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tomli_w

from servosight.bench.camera import VIDEO, Footage
from servosight.bench.servo import CommandLog, Reading
from servosight.bench.session._light import steady_stamps
from servosight.bench.timing import MEANINGS, ClockFit, SeenLight, mid_exposure
from servosight.models.core import Array, write_text
from servosight.models.io import FILES, table_text

SIGN = "bench.toml"
"""What was measured of the run's clocks and devices; a folder with it is the bench's own."""
RUN_FILES = (
    *FILES,
    VIDEO,
    "frames.csv",
    SIGN,
    "track.toml",
    "track_overlay.mp4",
    "track_sheet.png",
)
_NO_LIGHT = (
    "no coded light in view: the latency of the camera cannot be distinguished from dead time"
)


class Clocked(NamedTuple):
    """The camera's clock by the light, and the light."""

    fit: ClockFit
    light: SeenLight


def write_run(
    folder: Path,
    log: CommandLog,
    footage: Footage,
    clock: Clocked | None,
    servo: str,
    camera: str,
    fault: str | None,
    unlit: str | None = None,
) -> None:
    """Write all but the video, which stands in ``folder`` already."""
    start_s = log.sent[0][0]
    rows = np.array(log.sent)
    rows = rows[np.append(np.diff(rows[:, 0]) > 0.0, True)]
    text = table_text(("time_s", "command_deg"), (_micro(rows[:, 0] - start_s), rows[:, 1]))
    write_text(folder / "command.csv", text)
    stream = footage.stream
    mid_s = _mid_exposures(footage, clock) - start_s
    columns = [np.arange(mid_s.size, dtype=np.float64), _micro(mid_s)]
    write_text(folder / "frames.csv", table_text(("frame", "time_s"), columns))
    if log.readings:
        _write_readings(folder, log.readings, start_s)
    exposure_s = stream.exposure_s or (clock.fit.exposure_s if clock is not None else None)
    known = {"exposure_s": exposure_s, "readout_s": stream.readout_s, "rate_hz": footage.rate_hz}
    table: dict[str, Any] = {
        "format": 1,
        "hold": "zero",
        "video_offset_s": 0.0,
        "offset_sigma_s": _doubt_s(clock, log.sigma_s),
        "clock_note": _note(clock, unlit),
    }
    if fault is not None:
        table["ended"] = fault
    table["camera"] = {
        "width": stream.size[0],
        "height": stream.size[1],
        **{key: float(f"{value:.6g}") for key, value in known.items() if value is not None},
    }
    write_text(folder / "recording.toml", tomli_w.dumps(table))
    write_text(folder / SIGN, tomli_w.dumps(_measured(footage, clock, servo, camera)))


def _mid_exposures(footage: Footage, clock: Clocked | None) -> Array:
    """Mid-exposure times of the middle row on the host's clock [s], (frames,)."""
    stamps, stream = steady_stamps(footage), footage.stream
    readout_s = stream.readout_s or 0.0
    if clock is not None:
        return clock.fit.mid_exposure(stamps) + readout_s * (0.5 - clock.light.row)
    exposure_s = stream.exposure_s or 0.0
    if stream.host_clock and stream.meaning != "arrival":
        return mid_exposure(stamps, stream.meaning, exposure_s, readout_s)
    # The end of the first frames' delivery stands for the end of their readout.
    return mid_exposure(stamps + footage.delay_s, "frame_end", exposure_s, readout_s)


def _doubt_s(clock: Clocked | None, sent_sigma_s: float) -> float:
    """The standard deviation of the offset between command and video [s]."""
    if clock is None:
        return float("inf")
    return float(f"{math.hypot(clock.fit.offset_sigma_s, sent_sigma_s):.3g}")


def _note(clock: Clocked | None, unlit: str | None) -> str:
    if clock is None:
        return _NO_LIGHT if unlit is None else f"{_NO_LIGHT}; {unlit}"
    fit, (x, y) = clock.fit, clock.light.place_px
    return (
        f"the coded light at {x:.0f},{y:.0f} px gives the offset with a sigma of "
        f"{1e3 * fit.offset_sigma_s:.2g} ms and a drift of {1e6 * fit.drift:+.1f} ppm with a sigma "
        f"of {1e6 * fit.drift_sigma:.2g} ppm; frames.csv has both taken into account"
    )


def _measured(footage: Footage, clock: Clocked | None, servo: str, camera: str) -> dict[str, Any]:
    stream = footage.stream
    table: dict[str, Any] = {
        "servo": servo,
        "camera": camera,
        "frames": int(footage.number.size),
        "lost_frames": footage.lost,
        "stamp": MEANINGS[stream.meaning],
        "stamp_clock": "host" if stream.host_clock else "camera",
        "settings": dict(stream.settings),
    }
    if clock is not None:
        fit = clock.fit
        table["clock"] = {
            "offset_s": fit.offset_s,
            "offset_sigma_s": fit.offset_sigma_s,
            "drift": fit.drift,
            "drift_sigma": fit.drift_sigma,
            "exposure_s": fit.exposure_s,
            "correlation": fit.correlation,
            "light_px": list(clock.light.place_px),
        }
    return table


def _write_readings(folder: Path, readings: list[Reading], start_s: float) -> None:
    """signals.csv: what the servo reports of itself, each quantity that every reading has."""
    time_s = np.array([one.time_s for one in readings])
    rising = np.append(np.diff(time_s) > 0.0, True)
    columns = {"time_s": _micro(time_s - start_s)[rising]}
    names = {"angle_deg": "servo_angle_deg", "current_a": "current_A"}
    names |= {"voltage_v": "supply_V", "temperature_c": "temperature_c"}
    for name, column in names.items():
        values = [getattr(one, name) for one in readings]
        if all(value is not None for value in values):
            columns[column] = np.round(np.array(values, dtype=np.float64), 6)[rising]
    if len(columns) > 1:
        text = table_text(list(columns), list(columns.values()))
        write_text(folder / "signals.csv", text)


def _micro(time_s: Array) -> Array:
    return np.asarray(np.round(time_s, 6))
