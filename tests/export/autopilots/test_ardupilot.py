"""ArduPilot's SIM_SERVO parameters and the equations of its servo.

libraries/SITL/ServoModel.cpp: a buffer of int(SIM_SERVO_DELAY * SIM_RATE_HZ) samples, of which the
oldest is taken after the newest is put in; a rate limit by which 60 deg take SIM_SERVO_SPEED; a
Butterworth filter of second order with the cut-off SIM_SERVO_FILTER.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.servo import LINEAR, actuator

from servosight.export.core import export_model

BUTTERWORTH = {**LINEAR, "T": 0.05, "xi": 0.5**0.5, "k": 1.0, "bias": 0.0}


def values(path: Path) -> dict[str, float]:
    """What the parameter file sets."""
    rows = [row.split() for row in path.read_text(encoding="utf-8").splitlines() if row[0] != "#"]
    return {name: float(value) for name, value in rows}


def test_a_butterworth_servo_is_expressed_whole(tmp_path: Path) -> None:
    path = tmp_path / "fin.parm"
    servo = actuator(BUTTERWORTH, dead_time__delay=0.025, rate_limit__rate=300.0)
    result = export_model(servo, "ardupilot", path)
    found = values(path)
    assert found["SIM_SERVO_SPEED"] == pytest.approx(60.0 / 300.0)
    assert found["SIM_SERVO_FILTER"] == pytest.approx(1.0 / (2.0 * np.pi * 0.05), rel=1e-6)
    assert found["SIM_SERVO_DELAY"] == pytest.approx(0.025, abs=2.5 / 1200.0)
    assert int(found["SIM_SERVO_DELAY"] * 1200.0) - 1 == round(0.025 * 1200.0 + 0.5)
    assert (result.omissions, result.notes) == ((), ())
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < 0.05


def test_another_damping_costs_accuracy_and_that_is_said(tmp_path: Path) -> None:
    path = tmp_path / "fin.parm"
    result = export_model(actuator(), "ardupilot", path)
    cutoff = 2.0 * np.pi * values(path)["SIM_SERVO_FILTER"]
    assert np.sqrt(2.0) / cutoff == pytest.approx(2.0 * 0.6 * 0.04, rel=1e-5)  # delay 2 xi T
    assert values(path)["SIM_SERVO_SPEED"] == 0.0
    assert any("0.707 in place of 0.6" in note for note in result.notes)
    assert any("by 0.9" in note and "0.5 deg" in note for note in result.notes)
    assert result.difference_rms_deg is not None
    assert 0.1 < result.difference_rms_deg < 0.6


def test_limits_of_the_torque_become_a_limit_of_the_rate(tmp_path: Path) -> None:
    path = tmp_path / "fin.parm"
    result = export_model(actuator(torque_saturation__limit=6.0), "ardupilot", path)
    rate = 6.0 / (2.0 * 0.6 * 0.04) / 0.9
    assert values(path)["SIM_SERVO_SPEED"] == pytest.approx(60.0 / rate, rel=1e-4)
    (found,) = result.omissions
    assert found.approximation == f"rate limit of {rate:.3g} deg/s"
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < 0.4 * found.without_deg
