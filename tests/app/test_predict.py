"""servosight predict: a model runs on a new command, or on a recording's."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.app.main import main
from servosight.models.core import Actuator, Array, Estimate
from servosight.models.io import read_sheet

T, XI, K = 0.05, 0.7, 1.2
STEPS = "time_s,command_deg\n0,2\n0.1,8\n0.5,-3\n1,5\n2,0\n"


def risen(since: Array) -> Array:
    """The unit step response of G(s) = 1 / (T^2 s^2 + 2 xi T s + 1)."""
    damped = math.sqrt(1.0 - XI**2) / T
    since = np.maximum(since, 0.0)
    decay = np.exp(-XI / T * since)
    return 1.0 - decay * (np.cos(damped * since) + XI / (T * damped) * np.sin(damped * since))


def stepped(times: Array) -> Array:
    """The angle that answers ``STEPS``, in closed form."""
    jumps = ((0.1, 6.0), (0.5, -11.0), (1.0, 8.0), (2.0, -5.0))
    return K * 2.0 + 0.5 + K * sum(by * risen(times - at) for at, by in jumps)


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
    np.testing.assert_allclose(table[:, 1], K * 2.0 + 0.5 + K * 6.0 * risen(times - 0.1), atol=1e-6)
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


@pytest.mark.parametrize(("words", "rate_hz"), [([], 100.0), (["--rate", "250"], 250.0)])
def test_steps_far_apart_are_answered_between_their_rows(
    card: Path, tmp_path: Path, words: list[str], rate_hz: float
) -> None:
    """Angles in closed form on an even grid, from the first row to the last, in one table that
    reads as a recording."""
    command, angle = tmp_path / "command.csv", tmp_path / "angle.csv"
    command.write_text(STEPS)
    assert main(["predict", str(card), str(command), "-o", str(angle), *words]) == 0
    read = ss.read(angle)
    np.testing.assert_allclose(read.time_s, np.arange(round(2.0 * rate_hz) + 1) / rate_hz)
    np.testing.assert_allclose(read.angle_deg, stepped(read.time_s), atol=1e-5)
    assert read.command_deg[[0, -2, -1]].tolist() == [2.0, 5.0, 0.0]
    rate = None if not words else rate_hz
    np.testing.assert_array_equal(ss.predict(card, command, rate_hz=rate), read.angle_deg)


def test_a_dense_command_is_answered_at_its_rows(card: Path, tmp_path: Path) -> None:
    """Rows at 10 ms in decimals; one row left out makes them sparse."""
    times = [f"{0.01 * i:.2f}" for i in range(60)]
    command = tmp_path / "command.csv"
    command.write_text("time_s,command_deg\n" + "".join(f"{t},{t}\n" for t in times))
    assert ss.predict(str(card), str(command)).size == 60
    command.write_text("time_s,command_deg\n" + "".join(f"{t},{t}\n" for t in times if t != "0.30"))
    assert ss.predict(str(card), str(command)).size == 60
    assert ss.predict(card, command, rate_hz=5.0).size == 3


def test_a_motion_that_runs_away_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Integral action far too strong for its damping, by the command line and from Python."""
    values = {"k": K, "T": T, "xi": 0.1, "bias": 0.0}
    values |= {"integral_action.rate": 100.0, "integral_action.lag": 0.0}
    actuator = Actuator(
        {name: Estimate(value, None, "") for name, value in values.items()}, ("integral_action",)
    )
    card, command, angle = (tmp_path / name for name in ("m.toml", "command.csv", "angle.csv"))
    actuator.save(card)
    command.write_text(STEPS)
    assert main(["predict", str(card), str(command), "-o", str(angle)]) == 2
    assert "the model's simulation ends at" in capsys.readouterr().err
    assert not angle.exists()
    recording = ss.simulate(seed=3)
    for refused in (actuator.predict, lambda on: ss.compare(actuator, on)):
        with pytest.raises(ss.InputError, match="the model's simulation ends at"):
            refused(recording)


def test_a_model_behind_its_command_is_named(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = tmp_path / "command.csv"
    command.write_text(STEPS)
    assert main(["predict", str(command), str(card), "-o", str(tmp_path / "angle.csv")]) == 2
    assert "expected a model card" in capsys.readouterr().err


@pytest.mark.parametrize("rate", ["0", "-5", "0.4", "1e9"])
def test_a_rate_without_angles_or_with_too_many_is_refused(
    card: Path, tmp_path: Path, rate: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = tmp_path / "command.csv"
    command.write_text(STEPS)
    words = ["predict", str(card), str(command), "-o", str(tmp_path / "angle.csv")]
    assert main([*words, f"--rate={rate}"]) == 2
    said = capsys.readouterr().err
    assert "command.csv: the command lasts 2 s" in said
    assert "expected 2 to 20,000,000" in said
    assert said.count("\n") == 1


def test_a_rate_is_for_commands_only(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    rows = "".join(f"{0.01 * i:.2f},{i % 7},{i % 7}\n" for i in range(60))
    log.write_text(f"time_s,command_deg,angle_deg\n{rows}")
    words = ["predict", str(card), str(log), "-o", str(tmp_path / "angle.csv"), "--rate", "50"]
    assert main(words) == 2
    assert "log.csv: is a recording" in capsys.readouterr().err
    words[2] = str(tmp_path / "none.csv")
    assert main(words) == 2
    assert "none.csv: no such file" in capsys.readouterr().err
    with pytest.raises(ss.InputError, match="log: is a recording"):
        ss.predict(card, ss.read(log), rate_hz=50.0)


def test_a_table_is_the_users_and_the_sentence_says_so(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command, angle = tmp_path / "command.csv", tmp_path / "angle.csv"
    command.write_text(STEPS)
    words = ["predict", str(card), str(command), "-o", str(angle)]
    assert main(words) == 0
    first = angle.read_bytes()
    assert main([*words, "--rate", "50"]) == 2
    assert "a CSV file carries no mark of who wrote it" in capsys.readouterr().err
    assert angle.read_bytes() == first
    assert main([*words, "--rate", "50", "--force"]) == 0
    assert angle.read_bytes() != first
