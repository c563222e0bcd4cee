"""servosight excite: commands written, checked and analysed from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from servosight.app.commands.recording.excite import SHAPES
from servosight.app.main import main
from servosight.models.core import Actuator, Estimate, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.models.excitation import _design as design
from servosight.models.io import save_recording
from servosight.models.plant import Plant, Stimulus

PAPER = {"k": 1.027, "T": 0.0078, "xi": 0.55, "bias": 0.0}


@pytest.fixture
def card(tmp_path: Path) -> Path:
    """The paper's servo."""
    path = tmp_path / "model.toml"
    Actuator({name: Estimate(value, None, "") for name, value in PAPER.items()}).save(path)
    return path


def recorded(folder: Path, command: Path, **values: float) -> Path:
    """The command answered by the plant, at 120 Hz with 0.02 deg of noise."""
    plant, rows = Plant.of(catalogue()), Excitation.load(command)
    row = np.array(plant.layout.neutral_row())
    for name, value in {**PAPER, **values}.items():
        row[plant.index(name.replace("__", "."))] = value
    time_s = np.arange(int(120 * rows.duration_s)) / 120.0
    angle = plant.simulate(row, Stimulus(rows.time_s, rows.command_deg, False, time_s, np.ones(1)))
    angle += np.random.default_rng(3).normal(0.0, 0.02, time_s.size)
    save_recording(Recording("made", rows.time_s, rows.command_deg, time_s, angle), folder)
    return folder


def test_help_lists_every_shape_with_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert set(SHAPES) == {*design.SHAPES, "optimal"}
    assert main(["excite", "--help"]) == 0
    text = capsys.readouterr().out
    for name, words in SHAPES.items():
        assert f"  {name}" in text
        assert words in text


@pytest.mark.parametrize("shape", list(design.SHAPES))
def test_each_shape_is_written_with_its_header(shape: str, tmp_path: Path) -> None:
    path, result = tmp_path / "command.csv", tmp_path / "r.json"
    words = ["excite", shape, "--angle", "10", "--rate", "200", "--duration", "10", "--centre", "4"]
    assert main([*words, "-o", str(path), "--json", str(result)]) == 0
    assert path.read_text().splitlines()[0] == "time_s,command_deg"
    rows = Excitation.load(path)
    assert np.abs(rows.command_deg - 4.0).max() <= 10.0 + 1e-6
    assert np.abs(np.diff(rows.command_deg) / np.diff(rows.time_s)).max() <= 200.0 * (1 + 1e-5)
    values = json.loads(result.read_text())
    assert values["schema"] == 1
    assert values["largest_deg"] <= 10.0 + 1e-9


def test_the_papers_sine_is_found_wanting_and_an_optimal_command_is_not(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sine, better = tmp_path / "sine.csv", tmp_path / "better.csv"
    assert main(["excite", "sine", "-o", str(sine)]) == 0
    assert main(["excite", "--check", str(sine), "--model", str(card)]) == 0
    text = capsys.readouterr().out
    assert "does not determine" in text
    assert "T and xi are determined only together" in text
    assert "Within the same limits `servosight excite" in text
    words = ["excite", "optimal", "--model", str(card), "--for", "T,xi", "--rate", "126"]
    assert main([*words, "--duration", "10", "-o", str(better)]) == 0
    assert main(["excite", "--check", str(better), "--model", str(card), "--json", "-"]) == 0
    values = json.loads(capsys.readouterr().out.split("\n", 2)[2])
    assert values["sufficient"] is True
    assert values["unsure"] == []


def test_identify_warns_of_a_poor_command(tmp_path: Path) -> None:
    sine, result = tmp_path / "sine.csv", tmp_path / "r.json"
    assert main(["excite", "sine", "--duration", "8", "-o", str(sine)]) == 0
    rec = recorded(tmp_path / "rec", sine)
    assert main(["identify", str(rec), "--method", "gradient", "--json", str(result)]) == 0
    values = json.loads(result.read_text())
    assert set(values["information"]["unsure"]) == {"T", "xi"}
    assert any("does not determine" in warning for warning in values["warnings"])
    assert any("servosight excite" in warning for warning in values["warnings"])


def test_analyse_sees_play_and_nothing_in_a_linear_servo(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = tmp_path / "command.csv"
    words = ["excite", "multisine", "--rate", "300", "--duration", "12", "--seed", "2"]
    assert main([*words, "-o", str(command)]) == 0
    linear = recorded(tmp_path / "linear", command)
    loose = recorded(tmp_path / "loose", command, backlash__gap=1.0)
    result = tmp_path / "r.json"
    assert main(["excite", "--analyse", str(linear), "--json", str(result)]) == 0
    values = json.loads(result.read_text())
    assert not values["odd"]["found"]
    assert not values["even"]["found"]
    assert main(["excite", "--analyse", str(loose), "--json", str(result)]) == 0
    values = json.loads(result.read_text())
    assert values["odd"]["found"]
    assert not values["even"]["found"]
    assert "servosight diagnose" in capsys.readouterr().out


def test_wrong_words_give_one_sentence(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "c.csv")
    steps = tmp_path / "steps.csv"
    assert main(["excite", "steps", "--duration", "8", "-o", str(steps)]) == 0
    held = recorded(tmp_path / "held", steps)
    capsys.readouterr()
    for words, expected in (
        (["excite"], "a shape, --check and --analyse given, expected one of them"),
        (
            ["excite", "sine", "--check", out],
            "a shape, --check and --analyse given, expected one of them",
        ),
        (["excite", "sawtooth", "-o", out], "expected one of steps"),
        (["excite", "sine"], "-o command.csv"),
        (["excite", "sine", "--rate", "0", "-o", out], "the rate of the command is 0"),
        (
            ["excite", "sine", "--low", "3", "-o", out],
            "low_hz (--low on the command line) is 3, expected none",
        ),
        (["excite", "sine", "--model", str(card), "-o", out], "--model has no effect here"),
        (["excite", "sine", "--for", "T", "-o", out], "expected the shape optimal beside it"),
        (
            ["excite", "--check", str(steps), "--model", str(card), "--for", "T"],
            "--for has no effect here",
        ),
        (["excite", "optimal", "-o", out], "--model MODEL.toml"),
        (["excite", "optimal", "--model", str(card), "--for", "gap", "-o", out], "--for gap"),
        (
            ["excite", "optimal", "--model", str(card), "--noise", "0", "-o", out],
            "--noise 0: expected more than 0",
        ),
        (["excite", "--check", out, "--model", str(card)], "no such file"),
        (["excite", "--analyse", str(held)], "no periodic odd multisine"),
    ):
        assert main(words) == 2, words
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert expected in error, error
    assert not Path(out).exists()


@pytest.mark.parametrize("what", ["--check", "--analyse"])
def test_a_horn_beside_the_surface_is_passed_over(
    what: str, card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its folder yields two recordings, of which the surface's is the first."""
    command = tmp_path / "command.csv"
    assert main(["excite", "multisine", "--duration", "8", "-o", str(command)]) == 0
    folder = recorded(tmp_path / "rec", command)
    line = ["excite", what, str(folder), "--json", "-"]
    line += ["--model", str(card)] if what == "--check" else []
    capsys.readouterr()
    assert main(line) == 0
    alone = capsys.readouterr().out
    rows = (folder / "angle.csv").read_text().splitlines()
    (folder / "horn.csv").write_text("\n".join([rows[0], *rows[1:][::2]]) + "\n")
    assert main(line) == 0
    assert '"schema": 1' in alone
    assert capsys.readouterr().out == alone


@pytest.mark.parametrize(
    ("factor", "words"), [(1e-12, "check the unit of its times"), (1e9, "time_ms or time_us")]
)
def test_a_command_in_another_unit_of_time_is_refused(
    factor: float, words: str, card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = tmp_path / "command.csv"
    rows = "".join(f"{0.02 * i * factor!r},{i % 7}\n" for i in range(1, 60))
    command.write_text("time_s,command_deg\n" + rows)
    assert main(["excite", "--check", str(command), "--model", str(card)]) == 2
    assert words in capsys.readouterr().err
