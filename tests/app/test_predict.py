"""servosight predict: a model runs on a new command, or on a recording's."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Actuator, Estimate
from servosight.models.io import read_sheet

T, XI, K = 0.05, 0.7, 1.2


@pytest.fixture
def card(tmp_path: Path) -> Path:
    values = {"k": K, "T": T, "xi": XI, "bias": 0.5}
    path = tmp_path / "model.toml"
    Actuator({name: Estimate(value, None, "") for name, value in values.items()}).save(path)
    return path


def test_a_step_is_answered_as_the_equation_says(card: Path, tmp_path: Path) -> None:
    """G(s) = k / (T^2 s^2 + 2 xi T s + 1): the step response in closed form."""
    times = np.arange(0.0, 1.0, 0.01)
    command = np.where(times >= 0.1, 8.0, 2.0)
    body = "".join(f"{t:.2f},{u}\n" for t, u in zip(times, command, strict=True))
    (tmp_path / "command.csv").write_text(f"time_s,command_deg\n{body}")
    angle = tmp_path / "angle.csv"
    words = ["predict", str(card), str(tmp_path / "command.csv"), "-o", str(angle)]
    assert main(words) == 0
    table = read_sheet(angle).columns(["time_s", "angle_deg"])
    np.testing.assert_array_equal(table[:, 0], np.round(times, 2))
    since = np.maximum(times - 0.1, 0.0)
    damped = math.sqrt(1.0 - XI**2) / T
    decay = np.exp(-XI / T * since)
    risen = 1.0 - decay * (np.cos(damped * since) + XI / (T * damped) * np.sin(damped * since))
    np.testing.assert_allclose(table[:, 1], K * 2.0 + 0.5 + K * 6.0 * risen, atol=1e-6)
    assert main(words) == 2, "a table is not replaced"


def test_a_recording_is_predicted_at_its_times(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    times = 0.01 * np.arange(100)
    rows = "".join(f"{t:.2f},{5 * math.sin(6 * t):.6f},{5 * math.sin(6 * t):.6f}\n" for t in times)
    (tmp_path / "log.csv").write_text(f"time_s,command_deg,angle_deg\n{rows}")
    angle = tmp_path / "angle.csv"
    assert main(["predict", str(card), str(tmp_path / "log.csv"), "-o", str(angle)]) == 0
    assert "rms difference" in capsys.readouterr().out
    assert read_sheet(angle).columns(["time_s"]).shape == (100, 1)
