"""``--to ardupilot``: SIM_SERVO parameters of ArduPilot's simulator in the loop (SITL).

Its servo is a delay, a rate limit and a second-order Butterworth filter in series
(``libraries/SITL/ServoModel.cpp``). SITL is no Python package, so the trial runs on these
equations, restated here.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from servosight.export.autopilots._series import approximations, delay_s, rate_limits
from servosight.export.core import (
    Exporter,
    ExportRequest,
    ExportTrial,
    Omission,
    Response,
    mark_of,
    number,
    omitted,
    provenance_lines,
)
from servosight.models.core import Array, write_text

RATE_HZ = 1200.0
"""SIM_RATE_HZ where the user has not changed it."""
LARGEST_CUTOFF_HZ = 0.25 * RATE_HZ
TIME_FOR_DEG = 60.0
"""SIM_SERVO_SPEED is the time for so many degrees."""
BUTTERWORTH = math.sqrt(2.0)
"""A Butterworth filter of natural frequency w delays slow signals by sqrt(2) / w."""


def _write(request: ExportRequest, path: Path) -> None:
    rates = rate_limits(request)
    late = delay_s(request)
    lines = [f"# {mark_of('ardupilot')}", "#", *(f"# {x}" for x in provenance_lines(request)), "#"]
    lines += [
        f"# {note}" for note in (*_notes(request), "SIM_SERVO_SPEED 0: no rate limit") if note
    ]
    # A buffer of n samples, a whole number by rounding down, delays by n - 1. The filter's
    # trapezoidal rule answers half a sample early.
    delay = (round(late * RATE_HZ + 0.5) + 1.5) / RATE_HZ if late > 0.0 else 0.0
    values = {
        "SIM_SERVO_DELAY": delay,
        "SIM_SERVO_FILTER": _cutoff_hz(request),
        "SIM_SERVO_SPEED": TIME_FOR_DEG / min(rates.values()) if rates else 0.0,
    }
    lines += [f"{name} {number(round(value, 6))}" for name, value in values.items()]
    write_text(path, "\n".join(lines) + "\n")


def _cutoff_hz(request: ExportRequest) -> float:
    """Cut-off frequency of the filter that delays slow signals as the model's core does, by 2 xi T.

    Against a fit of cut-off and delay to the standard command it leaves an error of 1.0 to 1.8
    times the smallest, at damping ratios from 0.4 to 1.5; the natural frequency of the core as
    cut-off leaves up to 2.5 times.
    """
    T, xi = request.actuator.value("T"), request.actuator.value("xi")
    return min(BUTTERWORTH / (2.0 * math.pi * 2.0 * xi * T), LARGEST_CUTOFF_HZ)


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return omitted(request, ("dead_time", "rate_limit"), approximations(request))


def _notes(request: ExportRequest) -> tuple[str, ...]:
    k, xi, bias = (request.actuator.value(name) for name in ("k", "xi", "bias"))
    notes = []
    if abs(xi - 1.0 / BUTTERWORTH) > 0.05:
        notes.append(
            f"SITL's filter has a damping ratio of 0.707 in place of {xi:.3g}; its cut-off "
            f"is the one that delays slow signals alike"
        )
    if (k, bias) != (1.0, 0.0):
        notes.append(
            f"SITL's servo has neither gain nor offset: scale the deflection of the surface by "
            f"{k:.4g}, its angle at neutral is {bias:.3g} deg"
        )
    return tuple(notes)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    values = _read(path)
    first, last = trial.recording.time_s[[0, -1]]
    time_s = first + np.arange(int((last - first) * RATE_HZ) + 1) / RATE_HZ
    command = trial.recording.command_at(time_s)
    moved = servo_model(command, values) - command[0]
    angle = trial.start_deg + request.actuator.value("k") * moved
    return Response(time_s=time_s, angle_deg=angle)


def servo_model(command_deg: Array, values: dict[str, float]) -> Array:
    """SITL's servo on a command (samples,) at ``RATE_HZ`` [deg], from rest."""
    from scipy.signal import butter, lfilter

    samples = max(1, int(values["SIM_SERVO_DELAY"] * RATE_HZ)) - 1
    angle = command_deg[np.maximum(np.arange(command_deg.size) - samples, 0)]
    if values["SIM_SERVO_SPEED"] > 0.0:
        angle = _slewed(angle, TIME_FOR_DEG / values["SIM_SERVO_SPEED"] / RATE_HZ)
    top, bottom = butter(2, values["SIM_SERVO_FILTER"], fs=RATE_HZ)
    return np.asarray(angle[0] + lfilter(top, bottom, angle - angle[0]))


def _slewed(angle: Array, largest: float) -> Array:
    """Each value within ``largest`` of the one before."""
    made = angle.copy()
    last = float(angle[0])
    for index, value in enumerate(angle.tolist()):
        last = min(max(value, last - largest), last + largest)
        made[index] = last
    return made


def _read(path: Path) -> dict[str, float]:
    rows = path.read_text(encoding="utf-8").splitlines()
    pairs = (row.split() for row in rows if row and not row.startswith("#"))
    return {name: float(value) for name, value in pairs}


ARDUPILOT = Exporter(
    target="ArduPilot SITL (its servo's equations, restated)",
    write=_write,
    omissions=_omissions,
    run=_run,
    notes=_notes,
)
"""The exporter of ``--to ardupilot``."""
