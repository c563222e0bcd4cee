"""``--to control``: a Python file with the linear core as python-control systems."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np

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
from servosight.models.core import write_text

PADE_ORDER = 4
USUAL_STEP_S = 0.01
STEP_S = 1e-3
"""Sampling of a trial; the command's rows are held, as the servo holds them."""
TEXT = '''"""{mark}

{model}

Command and angle in degrees, time in seconds. The angle at zero command is bias_deg.
"""

import control

k = {k}
T = {T}
xi = {xi}
bias_deg = {bias}
delay_s = {delay}
sample_time_s = {step}

# G(s) = k / (T^2 s^2 + 2 xi T s + 1)
{name} = control.tf(
    [k], [T * T, 2.0 * xi * T, 1.0], name="{name}", inputs="command_deg", outputs="angle_deg"
)

# The same with the states angle [deg] and speed [deg/s].
{name}_ss = control.ss(
    [[0.0, 1.0], [-1.0 / T**2, -2.0 * xi / T]],
    [[0.0], [k / T**2]],
    [[1.0, 0.0]],
    [[0.0]],
    name="{name}_ss",
    inputs="command_deg",
    outputs="angle_deg",
    states=["angle_deg", "speed_deg_s"],
)

# The same behind its dead time, as a Pade approximation of order {order}.
{name}_delayed = {name}
if delay_s > 0.0:
    {name}_delayed = control.series(control.tf(*control.pade(delay_s, {order})), {name})

# At the sample time, without the dead time: the paper's eq. 2 for "tustin".
{name}_sampled = control.sample_system({name}, sample_time_s, method="{transform}")
'''


def _write(request: ExportRequest, path: Path) -> None:
    actuator, options = request.actuator, request.options
    delayed = "dead_time" in actuator.effects
    text = TEXT.format(
        mark=mark_of("control"),
        model="\n".join(provenance_lines(request)),
        **{name: number(actuator.value(name)) for name in ("k", "T", "xi", "bias")},
        delay=number(actuator.value("dead_time.delay") if delayed else 0.0),
        step=number(options.step_s(USUAL_STEP_S)),
        transform=options.transform,
        name=request.name,
        order=PADE_ORDER,
    )
    write_text(path, text)


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return omitted(request, (), {"dead_time": f"Pade approximation of order {PADE_ORDER}"})


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Run the file, and the system with dead time on the trial's held command."""
    import control

    made = runpy.run_path(str(path))
    first, last = trial.recording.time_s[[0, -1]]
    time_s = STEP_S * np.arange(int((last - first) / STEP_S) + 1)
    command = trial.recording.command_at(first + time_s)
    # In states, since the polynomials of a Pade approximation of milliseconds span 10^20.
    system = control.sample_system(
        control.tf2ss(made[f"{request.name}_delayed"]), STEP_S, method="zoh"
    )
    found = control.forced_response(system, time_s, command - command[0])
    angle = trial.start_deg + np.asarray(found.outputs, dtype=np.float64)
    return Response(time_s=first + time_s, angle_deg=angle)


CONTROL = Exporter(target="python-control", write=_write, omissions=_omissions, run=_run)
"""The exporter of ``--to control``."""
