"""``--to urdf``: the joint of a robot description, with its limits and friction.

URDF has no actuator: the position loop belongs to the simulator's controller. The trial runs the
description in MuJoCo, which reads URDF, under a controller of the model's stiffness.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.sax.saxutils import escape

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
from servosight.export.mjcf._rollout import rolled_out
from servosight.export.mjcf._text import HARD, Servo
from servosight.models.core import write_text

EXPRESSED = ("torque_saturation", "coulomb_friction")
INSTEAD = {
    "speed_limit": "effort limited to the stall torque, velocity to the no-load speed",
    "current_limit": "effort limited alike, without the back-EMF",
    "stribeck_friction": "friction of the sliding level",
    "presliding": "friction of the sliding level",
}
MASS_KG = 1e-3
TEXT = """<?xml version="1.0"?>
<!-- {mark}

{model}

Angles in radians, torques in N m for a stiffness of the position loop of {stiffness} N m/rad, which
the controller needs as its proportional gain. The controller's goal is {k} times the command plus
{bias} rad.
-->
<robot name="{name}">
  <link name="{name}_base"/>
  <link name="{name}_surface">
    <inertial>
      <mass value="{mass}"/>
      <inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/>
    </inertial>
  </link>
  <joint name="{name}" type="continuous">
    <parent link="{name}_base"/>
    <child link="{name}_surface"/>
    <axis xyz="0 0 1"/>
{limit}    <dynamics damping="{damping}" friction="{friction}"/>
  </joint>
</robot>
"""


def _write(request: ExportRequest, path: Path) -> None:
    servo = Servo(request)
    text = TEXT.format(
        mark=mark_of("urdf"),
        model=escape("\n".join(provenance_lines(request))).replace("--", "- -"),
        stiffness=number(servo.stiffness),
        k=number(servo.deg("k")),
        bias=number(math.radians(servo.deg("bias"))),
        name=request.name,
        mass=number(MASS_KG),
        inertia=number(servo.inertia),
        limit=_limit(servo),
        damping=number(servo.damping),
        friction=number(servo.torque(servo.friction_deg)),
    )
    write_text(path, text)


def _limit(servo: Servo) -> str:
    """Effort and velocity, where the model has a limit of the torque."""
    if not math.isfinite(servo.drive_limit_deg):
        return ""
    idle = servo.deg("speed_limit.no_load_speed", math.inf)
    fastest = math.radians(idle) if math.isfinite(idle) else UNLIMITED
    effort = number(servo.torque(servo.drive_limit_deg))
    return f'    <limit effort="{effort}" velocity="{number(fastest)}"/>\n'


UNLIMITED = 1e6
"""URDF wants both limits where it has one."""


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return omitted(request, EXPRESSED, INSTEAD)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """MuJoCo, with a position actuator of the model's stiffness on the joint as it was read."""
    import mujoco

    servo, name = Servo(request), request.name
    spec = mujoco.MjSpec.from_string(path.read_text(encoding="utf-8"))
    spec.option.timestep = servo.step_s
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    hinge = spec.joint(name)
    hinge.solref_friction = [2.0 * servo.step_s, 1.0]
    hinge.solimp_friction = [float(word) for word in HARD.split()]
    drive = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    drive.set_to_position(kp=servo.stiffness)
    model = spec.compile()
    recording = trial.recording
    first, last = recording.time_s[[0, -1]]
    time_s = first + servo.step_s * np.arange(int((last - first) / servo.step_s) + 1)
    goal = servo.deg("k") * recording.command_at(time_s) + servo.deg("bias")
    data = mujoco.MjData(model)
    data.qpos[0] = math.radians(trial.start_deg)
    states, _ = rolled_out(model, data, np.radians(goal))
    # Of a state the first number is the time; states are those after the step.
    angle = np.concatenate([[trial.start_deg], np.degrees(states[:-1, 1])])
    return Response(time_s=time_s, angle_deg=angle)


URDF = Exporter(target="MuJoCo, as a reader of URDF", write=_write, omissions=_omissions, run=_run)
"""The exporter of ``--to urdf``."""
