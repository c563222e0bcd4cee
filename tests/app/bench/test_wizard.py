"""``servosight bench wizard``: from plugging in to the experiment, by its questions."""

from __future__ import annotations

import argparse
import io
import os
import pty
import select
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path

import cv2
import numpy as np
import pytest
from support.wires import STAND_INS

from servosight.app.main import main
from servosight.app.parser import parser
from servosight.bench.camera import FoundCamera, open_camera
from servosight.bench.servo import open_servo
from servosight.bench.wire import MjpegServer, ServedFrame, VirtualClock, Wire
from servosight.models.core import InputError
from servosight.scenarios.bench_experiment import Zero

pytestmark = pytest.mark.pty
ANSWERS = {
    "dynamixel": ["1", "PORT", "", "", "led"],
    "feetech": ["2", "PORT", "1", "", ""],
    "maestro": ["3", "PORT", "0", "0.1", "", "24", "5"],
    "board": ["4", "PORT", ""],
}
CAMERA = ["CAMERA", "0.004"]
LIMITS = ["-30", "", "", "12", "results"]
"""Least and largest angle, rate, duration, folder."""


class Terminal(io.StringIO):
    """A terminal in which somebody types lines."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def camera() -> Iterator[str]:
    """Sixty frames a second of a printed pattern."""
    pattern = np.kron(np.random.default_rng(1).integers(0, 2, (12, 16)), np.ones((10, 10)))
    data = cv2.imencode(".jpg", (60 + 120 * pattern).astype(np.uint8))[1].tobytes()

    def film() -> Iterator[ServedFrame]:
        for n in range(200):
            yield ServedFrame(number=n, stamp_s=n / 60.0, data=data)

    with MjpegServer(film) as server:
        yield server.address


@pytest.fixture
def typed(
    camera: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[..., int]]:
    """Start the wizard before a virtual servo of a kind, with lines typed into it."""
    wires: list[Wire] = []

    def start(kind: str, lines: list[str], options: Sequence[str] = ()) -> int:
        wire = Wire(STAND_INS[kind]())
        wires.append(wire)
        clock = VirtualClock([wire])
        devices = import_module("servosight.app.commands.bench._devices")
        monkeypatch.setattr(devices, "open_servo", lambda a, limits: open_servo(a, limits, clock))
        monkeypatch.setattr(devices, "open_camera", lambda a, given: open_camera(a, given))
        words = {"PORT": wire.path, "CAMERA": camera}
        text = "".join(f"{words.get(line, line)}\n" for line in lines)
        monkeypatch.setattr("sys.stdin", Terminal(text))
        monkeypatch.chdir(tmp_path)
        code = main(["bench", "wizard", *options])
        assert not wire.servo.torque
        return code

    yield start
    for wire in wires:
        wire.close()


@pytest.fixture
def moves(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, argparse.Namespace]]:
    """What would have moved, in place of ``bench zero`` and ``bench auto``."""
    seen: list[tuple[str, argparse.Namespace]] = []
    standing = Zero(gain=0.9, neutral_deg=0.1, hysteresis_deg=0.3)

    def found(args: argparse.Namespace) -> Zero:
        seen.append(("zero", argparse.Namespace(**vars(args))))
        return standing

    def experiment(args: argparse.Namespace, zero: Zero | None = None) -> None:
        assert zero is standing  # what the user has seen and agreed to
        seen.append(("auto", argparse.Namespace(**vars(args))))

    actions = "servosight.app.commands.bench"
    monkeypatch.setattr(import_module(f"{actions}._zero"), "found", found)
    monkeypatch.setattr(import_module(f"{actions}._auto"), "experiment", experiment)
    return seen


@pytest.mark.parametrize("kind", list(STAND_INS))
def test_the_questions_lead_to_the_experiment(
    kind: str,
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    code = typed(kind, [*ANSWERS[kind], *CAMERA, *LIMITS, "arm", ""])
    said = capsys.readouterr()
    assert (code, said.err) == (0, "")
    (zero, at_zero), (auto, at_auto) = moves
    assert (zero, auto) == ("zero", "auto")
    assert (at_zero.output, at_auto.output) == (Path("results/zero"), Path("results"))
    assert (at_auto.arm, at_auto.low, at_auto.high, at_auto.rate) == (True, -30.0, 45.0, None)
    assert (at_auto.duration, at_auto.exposure, at_auto.yes) == (12.0, 0.004, False)
    assert at_auto.servo.startswith(f"{kind}:/dev/pts/")
    light = {"dynamixel": "&light=led", "maestro": "&light_channel=5"}.get(kind, "")
    assert at_auto.servo.endswith(light)
    assert ("light" in at_auto.servo) == bool(light)
    assert "frames/s measured" in said.out
    assert "ok  sharpness" in said.out
    assert "servosight bench auto -o results-again --arm" in said.out


def test_the_command_that_does_the_same_has_every_option(
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    given = "--neutral=-1.5 --acceleration 20000 --longest 60 --readout 0.0123456789"
    given += " --stamp frame_end --seed 5 --yes --force"
    limits = ["-30", "25.25", "400", "12", "results"]
    assert typed("feetech", [*ANSWERS["feetech"], *CAMERA, *limits, "arm", ""], given.split()) == 0
    _, (_, done) = moves
    line = capsys.readouterr().out.split("The same again, without questions: ")[1]
    again = parser().parse_args(shlex.split(line)[1:])
    assert again.output == Path("results-again")
    kept = {name: value for name, value in vars(done).items() if name in vars(again)}
    for name in ("output", "command_line"):
        kept.pop(name, None)
    assert {name: vars(again)[name] for name in kept} == kept
    assert (again.neutral, again.seed, again.stamp, again.rate) == (-1.5, 5, "frame_end", 400.0)


def test_nothing_moves_without_the_word(
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    for word in ("", "yes", "y"):
        assert typed("feetech", [*ANSWERS["feetech"], *CAMERA, *LIMITS, word]) == 0
        assert "Nothing moved." in capsys.readouterr().out
    assert moves == []


@pytest.mark.parametrize("count", range(13))
def test_it_can_be_ended_at_each_question(
    count: int,
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines = [*ANSWERS["maestro"], *CAMERA, *LIMITS][:count]
    for end in (["q"], []):  # or the end of the input, Ctrl-D
        assert typed("maestro", [*lines, *end]) == 0
        assert "Ended; nothing moves." in capsys.readouterr().out
    assert moves == []


def test_an_answer_that_cannot_be_is_asked_again(
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    nowhere = ["7", "one", "1", "/dev/none", "300", "1", "", "lamp", "dtr", "perhaps", "yes"]
    limits = ["10", "-30", "", "fast", "", "12", ""]
    lines = [*nowhere, *ANSWERS["dynamixel"], *CAMERA, *limits, "arm", "no"]
    assert typed("dynamixel", lines) == 0
    said = capsys.readouterr().out
    for words in (
        "type a number from 1 to 4",
        "300 is out of range; type a number from 0 to 252",
        "/dev/none",
        "type one of led, dtr, rts, none",
        "type yes or no",
        "'fast' is no number",
        "Ended",
    ):
        assert words in said
    ((name, args),) = moves
    assert (name, str(args.output)) == ("zero", "bench-results/zero")


def test_a_check_that_fails_is_repeated_until_all_is_in_order(
    typed: Callable[..., int],
    moves: list[tuple[str, argparse.Namespace]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines = [*ANSWERS["feetech"], "CAMERA", "0.016", *LIMITS, "", "", "q"]
    assert typed("feetech", lines) == 0
    assert capsys.readouterr().out.count("exposure not in order") == 3
    assert moves == []


def test_a_mode_of_the_list_becomes_an_address(
    typed: Callable[..., int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    usb = FoundCamera(
        device="v4l2:/dev/video0",
        name="A camera: 2",
        coding="MJPG",
        size=(640, 480),
        rates_hz=(120.0, 60.0, 30.0),
    )
    locked = FoundCamera(device="v4l2:/dev/video2", name="", fault="cannot be opened (refused)")
    listed = [locked, usb, FoundCamera(device="picamera2:0", name="imx296")]
    monkeypatch.setattr(import_module("servosight.bench.camera"), "list_cameras", lambda: listed)
    asked: list[str] = []

    def refused(address: str, given: object) -> None:
        asked.append(address)
        raise InputError(f"{address}: cannot be opened")

    def start(args: argparse.Namespace) -> None:
        refused(args.camera, None)

    cameras = import_module("servosight.app.commands.bench._cameras")
    monkeypatch.setattr(cameras, "run", start)
    lines = [*ANSWERS["board"], "1", "", "yes", "2", "0.002", "no"]
    assert typed("board", lines) == 0
    assert asked == [
        "v4l2:/dev/video0?format=MJPG&width=640&height=480&rate=120&exposure=0.0017",
        "picamera2:0?exposure=0.002",
    ]
    said = capsys.readouterr().out
    assert "  v4l2:/dev/video2: cannot be opened (refused)" in said
    assert "  1  v4l2:/dev/video0  A camera: 2  MJPG 640 x 480 at 120, 60, 30 frames/s" in said


def test_the_questions_are_seen_in_a_real_terminal() -> None:
    """Native libraries are kept from standard error there, and with it the prompts of input()."""
    ours, theirs = pty.openpty()
    line = [sys.executable, "-m", "servosight", "bench", "wizard"]
    with subprocess.Popen(line, stdin=theirs, stdout=theirs, stderr=theirs) as wizard:
        os.close(theirs)
        seen = b""
        while b"Which servo is it? [1] " not in seen:
            assert select.select([ours], [], [], 60.0)[0], seen
            seen += os.read(ours, 4096)
        os.write(ours, b"q\n")
        assert wizard.wait(60.0) == 0
        assert b"Ended; nothing moves." in os.read(ours, 4096)
    os.close(ours)


def test_without_a_terminal_it_says_so(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n"))
    assert main(["bench", "wizard"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no terminal" in error
