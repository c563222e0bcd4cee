"""The URDF joint, as MuJoCo reads it, and the SDF model, which has its numbers."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from support.servo import actuator

from servosight.export.core import ExportOptions, export_model

SIX_DEG = 6.0


def test_limits_and_friction_are_read_as_meant(tmp_path: Path) -> None:
    path = tmp_path / "fin.urdf"
    servo = actuator(torque_saturation__limit=SIX_DEG, coulomb_friction__level=0.5)
    result = export_model(servo, "urdf", path, options=ExportOptions(stiffness_nm_rad=3.0))
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.dof_damping[0] == pytest.approx(3.0 * 2.0 * 0.6 * 0.04)
    assert model.dof_frictionloss[0] == pytest.approx(3.0 * np.radians(0.5))
    assert model.jnt_actfrcrange[0] == pytest.approx(np.radians([-3.0 * SIX_DEG, 3.0 * SIX_DEG]))
    assert model.dof_M0[0] == pytest.approx(3.0 * 0.04**2)
    assert result.omissions == ()
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < 0.01


def test_what_a_joint_has_not_is_said(tmp_path: Path) -> None:
    servo = actuator(dead_time__delay=0.02, speed_limit__stall=20.0, speed_limit__no_load_speed=300)
    result = export_model(servo, "urdf", tmp_path / "fin.urdf")
    assert [(one.effect, one.approximation is None) for one in result.omissions] == [
        ("dead_time", True),
        ("speed_limit", False),
    ]
    velocity = f'velocity="{float(np.radians(300.0))!r}"'
    assert velocity in (tmp_path / "fin.urdf").read_text(encoding="utf-8")


def test_the_sdf_has_the_numbers_of_the_urdf(tmp_path: Path) -> None:
    """The controller's gain is the stiffness, its clip the effort; Gazebo itself is not run."""
    servo = actuator(torque_saturation__limit=SIX_DEG, coulomb_friction__level=0.5)
    options = ExportOptions(stiffness_nm_rad=3.0)
    result = export_model(servo, "sdf", tmp_path / "fin.sdf", options=options)
    export_model(servo, "urdf", tmp_path / "fin.urdf", options=options)
    model = ET.parse(tmp_path / "fin.sdf").getroot()
    robot = ET.parse(tmp_path / "fin.urdf").getroot()
    dynamics, limit = robot.find("joint/dynamics"), robot.find("joint/limit")
    inertia = robot.find("link/inertial/inertia")
    assert dynamics is not None
    assert limit is not None
    assert inertia is not None
    for path, value in (
        (".//axis/dynamics/damping", dynamics.get("damping")),
        (".//axis/dynamics/friction", dynamics.get("friction")),
        (".//axis/limit/effort", limit.get("effort")),
        (".//plugin/cmd_max", limit.get("effort")),
        (".//plugin/p_gain", "3.0"),
        (".//inertia/izz", inertia.get("izz")),
        (".//axis/limit/velocity", None),
    ):
        assert model.findtext(path) == value
    assert result.not_run is not None
    assert "Gazebo" in result.not_run
