"""The JSBSim system file, run in JSBSim."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support.round_trip import assert_comes_back
from support.servo import LINEAR, actuator, short_trial

from servosight.app.main import main
from servosight.export.autopilots import JSBSIM
from servosight.export.core import ExportOptions, ExportRequest, export_model
from servosight.models.effects import catalogue

pytest.importorskip("jsbsim", reason="JSBSim is not installed (group dev)")

FINE = ExportOptions(sample_time_s=1e-3)


@pytest.mark.parametrize(
    ("effects", "largest_rms"),
    [
        # The trapezoidal rule answers half a step early: 0.5 ms of some 60 deg/s rms.
        ({}, 0.04),
        ({"dead_time__delay": 0.0305}, 0.003),
        ({"command_quantization__step": 1.0}, 0.04),
        ({"rate_limit__rate": 150.0}, 0.06),
        ({"backlash__gap": 1.0}, 0.04),
        ({"linkage_geometry__horn": 0.8, "linkage_geometry__offset": 15.0}, 0.04),
    ],
)
def test_what_it_expresses_agrees(
    effects: dict[str, Any], largest_rms: float, tmp_path: Path
) -> None:
    result = export_model(
        actuator(**effects), "jsbsim", tmp_path / "fin.xml", options=FINE, on=short_trial()
    )
    assert result.omissions == ()
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < largest_rms


@pytest.mark.parametrize(
    ("effects", "share"),
    [
        ({"torque_saturation__limit": 6.0}, 0.4),
        ({"current_limit__limit": 4.0, "current_limit__back_emf": 0.02}, 0.4),
        ({"speed_limit__stall": 20.0, "speed_limit__no_load_speed": 200.0}, 0.75),
        ({"motion_profile__rate": 150.0, "motion_profile__acceleration": 3000.0}, 0.6),
        ({"coulomb_friction__level": 0.5}, 0.9),
        ({"dead_zone__half_width": 0.5}, 0.9),
    ],
)
def test_what_stands_in_for_an_effect_is_better_than_nothing(
    effects: dict[str, Any], share: float, tmp_path: Path
) -> None:
    result = export_model(
        actuator(**effects), "jsbsim", tmp_path / "fin.xml", options=FINE, on=short_trial()
    )
    (found,) = result.omissions
    assert found.approximation is not None
    assert result.difference_rms_deg is not None
    assert result.difference_rms_deg < share * found.without_deg


def test_a_coarse_step_is_measured_and_nothing_else_is_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    actuator({**LINEAR, "T": 0.01}).save(tmp_path / "model.toml")
    words = [
        "export",
        str(tmp_path / "model.toml"),
        "--to",
        "jsbsim",
        "-o",
        str(tmp_path / "a.xml"),
    ]
    assert main(words) == 0
    said = capfd.readouterr().out
    assert said.count("\n") == 3
    assert "note: JSBSim was run at steps of 0.008333 s; at 0.001 s" in said
    assert main(words) == 0, "its own file is replaced"


def test_the_card_comes_back_from_a_recording_made_in_jsbsim(tmp_path: Path) -> None:
    """Card, system file, JSBSim, noise, identify: each parameter within three sigma."""
    card = actuator(dead_time__delay=0.0205, backlash__gap=1.2)
    request = ExportRequest(actuator=card, catalogue=catalogue(), options=FINE)
    assert_comes_back(JSBSIM, request, tmp_path / "servo.xml", rate_hz=125)
