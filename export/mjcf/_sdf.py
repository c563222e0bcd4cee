"""``--to sdf``: the servo for Gazebo, a joint with limits and friction and its position controller.

Gazebo is no Python package: the file is written and not run.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.sax.saxutils import escape

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
from servosight.export.mjcf._text import Servo
from servosight.export.mjcf._urdf import EXPRESSED, INSTEAD, MASS_KG
from servosight.models.core import write_text

TEXT = """<?xml version="1.0"?>
<!-- {mark}

{model}

Angles in radians, torques in N m for a stiffness of the position loop of {stiffness} N m/rad, the
controller's proportional gain; damping is the joint's. The controller's goal, on the topic
/{name}/goal, is {k} times the command plus {bias} rad.
-->
<sdf version="1.9">
  <model name="{name}">
    <link name="base">
    </link>
    <link name="surface">
      <inertial>
        <mass>{mass}</mass>
        <inertia>
          <ixx>{inertia}</ixx><ixy>0</ixy><ixz>0</ixz><iyy>{inertia}</iyy><iyz>0</iyz><izz>{inertia}</izz>
        </inertia>
      </inertial>
    </link>
    <joint name="mount" type="fixed">
      <parent>world</parent>
      <child>base</child>
    </joint>
    <joint name="{name}" type="revolute">
      <parent>base</parent>
      <child>surface</child>
      <axis>
        <xyz>0 0 1</xyz>
{limit}        <dynamics>
          <damping>{damping}</damping>
          <friction>{friction}</friction>
        </dynamics>
      </axis>
    </joint>
    <plugin filename="gz-sim-joint-position-controller-system"
            name="gz::sim::systems::JointPositionController">
      <joint_name>{name}</joint_name>
      <topic>/{name}/goal</topic>
      <p_gain>{stiffness}</p_gain>
      <i_gain>0</i_gain>
      <d_gain>0</d_gain>
{clip}    </plugin>
  </model>
</sdf>
"""
CLIP = "      <cmd_max>{effort}</cmd_max>\n      <cmd_min>-{effort}</cmd_min>\n"


def _write(request: ExportRequest, path: Path) -> None:
    servo = Servo(request)
    limited = math.isfinite(servo.drive_limit_deg)
    effort = number(servo.torque(servo.drive_limit_deg)) if limited else ""
    text = TEXT.format(
        mark=mark_of("sdf"),
        model=escape("\n".join(provenance_lines(request))).replace("--", "- -"),
        stiffness=number(servo.stiffness),
        k=number(servo.deg("k")),
        bias=number(math.radians(servo.deg("bias"))),
        name=request.name,
        mass=number(MASS_KG),
        inertia=number(servo.inertia),
        limit=_limit(servo, effort) if limited else "",
        damping=number(servo.damping),
        friction=number(servo.torque(servo.friction_deg)),
        clip=CLIP.format(effort=effort) if limited else "",
    )
    write_text(path, text)


def _limit(servo: Servo, effort: str) -> str:
    """Effort, and velocity where the model's no-load speed is known."""
    idle = servo.deg("speed_limit.no_load_speed", math.inf)
    fastest = f"<velocity>{number(math.radians(idle))}</velocity>" if math.isfinite(idle) else ""
    return f"        <limit><effort>{effort}</effort>{fastest}</limit>\n"


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return omitted(request, EXPRESSED, INSTEAD)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    raise NotImplementedError(path)  # never: it is missing


def _missing() -> str | None:
    return "Gazebo cannot be run from Python; the file holds the numbers of --to urdf, which is run"


SDF = Exporter(target="Gazebo", write=_write, omissions=_omissions, run=_run, missing=_missing)
"""The exporter of ``--to sdf``."""
