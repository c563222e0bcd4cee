"""The MuJoCo model, run in MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from support.round_trip import assert_comes_back
from support.servo import LINEAR, actuator, short_trial

import servosight as ss
from servosight.export.core import ExportOptions, ExportRequest, export_model
from servosight.export.mjcf import MJCF
from servosight.models.effects import catalogue

SHAFT = {"frequency": 12.0, "damping": 0.08, "inertia_ratio": 0.3}


@pytest.mark.parametrize(
    ("effects", "largest_rms"),
    [
        ({}, 1e-5),
        ({"torque_saturation__limit": 6.0}, 1e-4),
        ({"hinge_hardening__cubic": 5e-4}, 1e-4),
        ({"quadratic_drag__coefficient": 2e-4}, 1e-4),
        ({f"flexible_shaft__{name}": value for name, value in SHAFT.items()}, 1e-3),
        # Held commands change between stages of a step: a sixth of a step early.
        ({"dead_time__delay": 0.03}, 0.01),
        ({"coulomb_friction__level": 0.5}, 0.004),
        ({"backlash__gap": 1.0}, 0.005),
        (
            {
                "dead_time__delay": 0.02,
                "torque_saturation__limit": 8.0,
                "coulomb_friction__level": 0.3,
                "backlash__gap": 0.8,
            },
            0.01,
        ),
    ],
)
def test_what_it_expresses_agrees(
    effects: dict[str, Any], largest_rms: float, tmp_path: Path
) -> None:
    result = export_model(actuator(**effects), "mjcf", tmp_path / "fin.xml", on=short_trial())
    assert result.omissions == ()
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < largest_rms


@pytest.mark.parametrize(
    ("effects", "share"),
    [
        ({"gravity_load__sine": 4.0, "gravity_load__cosine": 5.0}, 0.05),
        (
            {
                "stribeck_friction__level": 0.4,
                "stribeck_friction__excess": 0.3,
                "stribeck_friction__speed": 10.0,
            },
            0.3,
        ),
        ({"presliding__level": 0.5, "presliding__stiffness": 5.0}, 0.3),
        ({"current_limit__limit": 4.0, "current_limit__back_emf": 0.02}, 0.6),
        ({"speed_limit__stall": 20.0, "speed_limit__no_load_speed": 200.0}, 0.9),
    ],
)
def test_what_stands_in_for_an_effect_is_better_than_nothing(
    effects: dict[str, Any], share: float, tmp_path: Path
) -> None:
    result = export_model(actuator(**effects), "mjcf", tmp_path / "fin.xml", on=short_trial())
    (found,) = result.omissions
    assert found.approximation is not None
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < share * found.without_deg


def test_neutral_effects_change_nothing(tmp_path: Path) -> None:
    neutral = actuator(backlash__gap=0.0, dead_time__delay=0.0, coulomb_friction__level=0.0)
    result = export_model(neutral, "mjcf", tmp_path / "fin.xml")
    assert result.difference_rms_deg == pytest.approx(0.0, abs=1e-5)
    light = {f"flexible_shaft__{name}": value for name, value in SHAFT.items()}
    light["flexible_shaft__inertia_ratio"] = 0.0
    result = export_model(actuator(**light), "mjcf", tmp_path / "fin.xml")
    assert result.difference_rms_deg == pytest.approx(0.0, abs=1e-3)


def test_the_stiffness_scales_torques_and_leaves_the_motion(tmp_path: Path) -> None:
    servo = actuator(coulomb_friction__level=0.5)
    soft, stiff = tmp_path / "soft.xml", tmp_path / "stiff.xml"
    export_model(servo, "mjcf", soft)
    result = export_model(servo, "mjcf", stiff, options=ExportOptions(stiffness_nm_rad=20.0))
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < 0.004
    one, other = (mujoco.MjModel.from_xml_path(str(path)) for path in (soft, stiff))
    for name in ("dof_armature", "dof_damping", "dof_frictionloss"):
        np.testing.assert_allclose(getattr(other, name), 20.0 * getattr(one, name), rtol=1e-12)
    # Friction of 0.5 deg of position error at 20 N m/rad.
    assert other.dof_frictionloss[0] == pytest.approx(20.0 * np.radians(0.5))
    with pytest.raises(ss.InputError, match=r"stiffness_nm_rad \(--stiffness .*\) is 0"):
        export_model(servo, "mjcf", soft, options=ExportOptions(stiffness_nm_rad=0.0))


def test_a_step_that_is_too_long_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one sentence, without MuJoCo's log in the working directory, and without a file."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ss.InputError, match=r"unstable at steps of 0\.5 s"):
        export_model(actuator(), "mjcf", Path("a.xml"), options=ExportOptions(sample_time_s=0.5))
    assert list(tmp_path.iterdir()) == []


def test_a_servo_that_starts_elsewhere_settles_first(tmp_path: Path) -> None:
    time_s = np.arange(0.0, 2.0, 0.01)
    command = np.where(time_s < 1.0, 12.0, -3.0)
    start = ss.Recording("start", time_s, command, time_s, np.zeros(200), exposure_s=0.0)
    servo = actuator({**LINEAR, "k": -1.1}, dead_time__delay=0.03)
    result = export_model(servo, "mjcf", tmp_path / "fin.xml", on=start)
    assert result.difference_max_deg is not None
    assert result.difference_max_deg < 0.05


def test_the_card_comes_back_from_a_recording_made_in_mujoco(tmp_path: Path) -> None:
    """Card, MuJoCo model, noise, identify: each parameter within three sigma."""
    card = actuator(coulomb_friction__level=0.4, backlash__gap=1.2)
    request = ExportRequest(actuator=card, catalogue=catalogue())
    assert_comes_back(MJCF, request, tmp_path / "servo.xml", rate_hz=125)
