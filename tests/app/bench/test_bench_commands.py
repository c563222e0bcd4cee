"""``servosight bench``: what it lists, refuses and records."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.bench.wire import MjpegServer, ServedFrame
from servosight.models.excitation import standard

DEVICES = ("--servo", "maestro:/dev/none", "--camera", "none.mkv")
AUTO = ("auto", "-o", "x", *DEVICES)


@pytest.fixture
def camera() -> Iterator[str]:
    """A stream of sixty frames a second of a printed pattern, 60 times faster than it says."""
    pattern = np.kron(np.random.default_rng(1).integers(0, 2, (12, 16)), np.ones((10, 10)))
    data = cv2.imencode(".jpg", (60 + 120 * pattern).astype(np.uint8))[1].tobytes()

    def film() -> Iterator[ServedFrame]:
        for n in range(200):
            yield ServedFrame(number=n, stamp_s=n / 60.0, data=data)
        time.sleep(1.0)

    with MjpegServer(film) as server:
        yield server.address


def complaint(capsys: pytest.CaptureFixture[str], line: list[str]) -> str:
    """The one sentence of bad input."""
    assert main(["bench", *line]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def test_devices_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "servos"]) == 0
    assert "dynamixel" in capsys.readouterr().out
    assert main(["bench", "cameras"]) == 0
    assert capsys.readouterr().out


def test_a_cameras_real_rate_is_measured(capsys: pytest.CaptureFixture[str], camera: str) -> None:
    assert main(["bench", "cameras", "--camera", camera]) == 0
    said = capsys.readouterr().out
    assert "160 x 120, mjpeg, 60.000 frames/s" in said
    assert "the end of the last row's readout" in said


def test_a_check_says_what_is_not_in_order(capsys: pytest.CaptureFixture[str], camera: str) -> None:
    line = ["check", "--camera", camera]
    assert main(["bench", *line, "--exposure", "0.004"]) == 0
    assert "NO" not in capsys.readouterr().out
    assert "exposure not in order" in complaint(capsys, [*line, "--exposure", "0.015"])


def test_nothing_moves_without_arm(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    command = tmp_path / "command.csv"
    standard(4.0, 10.0, 1, 50.0).save(command)
    devices = ["--servo", "maestro:/dev/none", "--camera", "none.mkv"]
    output = ["-o", str(tmp_path / "rec")]
    assert "--arm" in complaint(capsys, ["run", str(command), *output, *devices])
    for action in ("zero", "auto"):
        assert "--arm" in complaint(capsys, [action, *output, *devices])
    assert not (tmp_path / "rec").exists()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["jump"], "invalid choice: 'jump'"),
        (["rehears"], "did you mean rehearse?"),
        (["check"], "needs --camera"),
        (["run"], "required: EXCITATION, -o/--output, --servo, --camera"),
        (["rehearse"], "needs -o"),
        (["rehearse", "-o", "x", "--duration", "2"], "expected 4 to 120 seconds"),
        ([*AUTO, "--duration", "121"], "expected 4 to 120 seconds"),
        (["target", "-o", "x", "--servo", "maestro:x"], "unrecognized arguments: --servo"),
        (["cameras", "-o", "x"], "unrecognized arguments: -o"),
        (["cameras", "--seed", "4"], "unrecognized arguments: --seed"),
        (["servos", "--camera", "x"], "unrecognized arguments: --camera"),
        (["check", "--servo", "maestro:x", "--force"], "see `servosight bench check --help`"),
        (["zero", "-o", "x", "--duration", "9", *DEVICES], "unrecognized arguments: --duration"),
        (["run", "a.csv", "-o", "x", "--yes", *DEVICES], "unrecognized arguments: --yes"),
        ([*AUTO, "--kind", "board"], "unrecognized arguments: --kind"),
        (["wizard", "--low", "-5"], "unrecognized arguments: --low"),
        (["firmware", "-o", "x", "--low", "3"], "unrecognized arguments: --low"),
        (["rehearse", "-o", "x", "--camera", "x"], "unrecognized arguments: --camera"),
        (["rehearse", "--serve", "-o", "x"], "-o has no effect with --serve"),
        (["rehearse", "--serve", "--duration", "9"], "--duration has no effect with --serve"),
        (["cameras", "--exposure", "0.01"], "--exposure has no effect here, expected --camera"),
        (["servos", "--low", "-5"], "--low has no effect here, expected --servo ADDRESS"),
        (["check", "--camera", "x", "--low", "-5"], "expected --servo ADDRESS beside it"),
        (["check", "--servo", "x", "--stamp", "arrival"], "expected --camera ADDRESS beside it"),
        (["check", "--servo", "x", "--arm"], "expected both --camera and --servo"),
        (["check", "--camera", "http://127.0.0.1:9/"], "does not answer"),
        (["servos", "--servo", "maestro:/dev/none"], "/dev/none"),
        (
            ["check", "--camera", "x", "--exposure", "7"],
            "exposure_s (--exposure on the command line) is 7",
        ),
        (
            ["check", "--servo", "maestro:/dev/none", "--low", "50"],
            "low_deg (--low on the command line) is 50",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(
    capsys: pytest.CaptureFixture[str], line: list[str], words: str
) -> None:
    assert words in complaint(capsys, line)


def test_the_command_may_stand_behind_the_options(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = ["run", "-o", str(tmp_path / "rec"), *DEVICES, str(tmp_path / "command.csv")]
    assert "no such file" in complaint(capsys, line)


@pytest.mark.parametrize(
    ("action", "used", "other"),
    [("run", "EXCITATION", "--seed"), ("target", "FILE.png", "--low"), ("auto", "20", "--kind")],
)
def test_the_help_of_an_action_names_what_it_uses(
    capsys: pytest.CaptureFixture[str], action: str, used: str, other: str
) -> None:
    assert main(["bench", action, "--help"]) == 0
    said = capsys.readouterr().out
    assert f"usage: servosight bench {action} " in said
    assert used in said
    assert other not in said


@pytest.mark.parametrize("line", ["rehearse", "auto --arm --servo maestro:x --camera x.mp4"])
def test_a_file_in_the_folders_place_is_refused(
    line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "taken").write_text("mine")
    assert main(["bench", *line.split(), "-o", str(tmp_path / "taken")]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="not installed: avr-gcc")
def test_the_firmware_is_compiled_and_how_to_write_it_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "firm ware"
    line = ["bench", "firmware", "-o", str(place), "--servo", "board:/dev/ttyACM3?period_ms=20"]
    for _ in range(2):  # again, over its own
        assert main(line) == 0
    said = capsys.readouterr().out
    assert f"-P /dev/ttyACM3 -U 'flash:w:{place}/board.hex'" in said
    assert (place / "board.hex").read_text().splitlines()[-1] == ":00000001FF"
    assert "int main" in (place / "board.c").read_text()
    (place / "mine.txt").write_text("mine")
    assert "mine.txt" in complaint(capsys, line[1:])


def test_the_page_to_print_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "target.png"
    for _ in range(2):  # again, over its own
        assert main(["bench", "target", "-o", str(place)]) == 0
    assert "measure the line of 100 mm" in capsys.readouterr().out
    mine = tmp_path / "mine.png"
    mine.write_bytes(b"mine")
    assert "mine.png" in complaint(capsys, ["target", "-o", str(mine)])
    assert "required: -o" in complaint(capsys, ["target"])


def test_the_firmware_needs_its_compiler(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "required: -o" in complaint(capsys, ["firmware"])
    monkeypatch.setenv("PATH", str(tmp_path))
    line = ["firmware", "-o", str(tmp_path / "new")]
    assert "install the packages gcc-avr" in complaint(capsys, line)
    compiler = tmp_path / "avr-gcc"
    compiler.write_text("#!/bin/sh\necho 'board.c:1: error: avr/io.h: no such file' >&2\nexit 1\n")
    compiler.chmod(0o755)
    assert "avr/io.h" in complaint(capsys, line)
    assert not (tmp_path / "new").exists()
