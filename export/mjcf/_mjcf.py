"""``--to mjcf``: the servo as a MuJoCo model (MJCF), run in MuJoCo.

Torque in the model is in degrees of position error. The stiffness of the position loop, which no
angle shows, makes newton metres of it; MuJoCo's angles are radians.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from servosight.export.core import (
    Exporter,
    ExportRequest,
    ExportTrial,
    Omission,
    Response,
    omitted,
)
from servosight.export.mjcf._rollout import rolled_out
from servosight.export.mjcf._text import model_text
from servosight.models.core import write_text

EXPRESSED = (
    "dead_time",
    "torque_saturation",
    "coulomb_friction",
    "quadratic_drag",
    "hinge_hardening",
    "flexible_shaft",
    "backlash",
)
INSTEAD = {
    "speed_limit": "torque limited to the stall torque",
    "current_limit": "torque limited alike, without the back-EMF",
    "stribeck_friction": "friction loss of the sliding level",
    "presliding": "friction loss of the sliding level",
    "gravity_load": "offset and spring about the zero angle",
}


def _write(request: ExportRequest, path: Path) -> None:
    write_text(path, model_text(request))


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return omitted(request, EXPRESSED, INSTEAD)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Load the file, settle at the first command, and run through the trial."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    step_s = float(model.opt.timestep)
    recording = trial.recording
    first, last = recording.time_s[[0, -1]]
    time_s = first + step_s * np.arange(int((last - first) / step_s) + 1)
    command = np.radians(recording.command_at(time_s))
    # Delayed commands begin at zero: another first command is held until the servo rests there.
    waiting = 0 if command[0] == 0.0 else math.ceil(_settling_s(request) / step_s)
    given = np.concatenate([np.full(waiting, command[0]), command])
    data = mujoco.MjData(model)
    resting = {f"{request.name}_{part}": math.radians(trial.start_deg) for part in ("motor", "fin")}
    joints = {model.joint(index).name: model.joint(index) for index in range(model.njnt)}
    for name, joint in joints.items():
        data.qpos[joint.qposadr[0]] = resting.get(name, 0.0)
    # Sensors are read before each step: at the time of its command.
    _, sensed = rolled_out(model, data, given)
    return Response(time_s=time_s, angle_deg=np.degrees(sensed[waiting:, 0]))


def _settling_s(request: ExportRequest) -> float:
    """Time [s] after which the slowest part of a step has gone."""
    T, xi = request.actuator.value("T"), request.actuator.value("xi")
    delayed = "dead_time" in request.actuator.effects
    late = request.actuator.value("dead_time.delay") if delayed else 0.0
    return late + 20.0 * T * max(2.0 * xi, 1.0 / xi)


MJCF = Exporter(target="MuJoCo", write=_write, omissions=_omissions, run=_run)
"""The exporter of ``--to mjcf``."""
