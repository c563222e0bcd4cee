"""An interruption ends the process even where code swallows it or turns it into an error."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from fuzz.kills import not_ignored

SWALLOWING = """
try:
    while True:
        time.sleep(60)
except BaseException:
    pass
time.sleep(60)
"""
CONVERTING = """
try:
    time.sleep(60)
except BaseException:
    raise AttributeError("module 'networkx' has no attribute 'Graph'") from None
"""
DELETING = """
class Slow:
    def __del__(self):
        time.sleep(60)
slow = Slow()
del slow
time.sleep(60)
"""
HALF_MADE = """
class Half:
    def __init__(self):
        time.sleep(60)
        self.handle = 1
    def __del__(self):
        del self.handle
Half()
"""
PRINTING = """
import ctypes
ctypes.pythonapi.PyRun_SimpleString(b"import time; time.sleep(60)")
time.sleep(60)
"""
PLAIN = "time.sleep(60)"


@pytest.fixture(autouse=True)
def signals_not_ignored() -> Iterator[None]:
    with not_ignored():
        yield


def interrupted(body: str, number: signal.Signals, folder: Path) -> tuple[int, str]:
    """Run ``body`` as the command ``effects``, with a temporary made, and interrupt it."""
    lines = "\n".join(f"    {line}" for line in body.strip().splitlines())
    script = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from servosight.app.commands import COMMANDS\n"
        "from servosight.app.main import main\n"
        "from servosight.models.base import temporary_file\n"
        "def run(args):\n"
        f"    temporary_file(Path({str(folder / 'result.json')!r}))\n"
        "    print('ready', flush=True)\n"
        f"{lines}\n"
        "COMMANDS['effects'].run = run\n"
        "sys.argv = ['servosight', 'effects']\n"
        "sys.exit(main())\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    assert len(list(folder.iterdir())) == 1
    process.send_signal(number)
    _, said = process.communicate(timeout=30)
    return process.returncode, said


@pytest.mark.parametrize("body", [SWALLOWING, CONVERTING, DELETING, HALF_MADE, PRINTING, PLAIN])
def test_an_interruption_ends_the_process_whatever_it_is_at(body: str, tmp_path: Path) -> None:
    code, said = interrupted(body, signal.SIGINT, tmp_path)
    assert (code, said) == (130, "servosight: interrupted\n")
    if body != CONVERTING and body != PLAIN:  # those left their blocks, which clean up themselves
        assert list(tmp_path.iterdir()) == []


STARTED = "import os, signal, sys, time; before = set(sys.modules); import _servosight; "


def test_the_entry_point_loads_nothing_before_it_handles_an_interruption() -> None:
    script = "print(sorted(set(sys.modules) - before))"
    done = subprocess.run([sys.executable, "-c", STARTED + script], capture_output=True, text=True)
    assert done.stdout == "['_servosight']\n", done.stderr
    (entry,) = entry_points(group="console_scripts", name="servosight")
    assert entry.value == "_servosight:main"


def test_an_interruption_before_the_command_is_loaded_ends_it() -> None:
    script = "os.kill(os.getpid(), signal.SIGINT); time.sleep(30)"
    done = subprocess.run([sys.executable, "-c", STARTED + script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_other_signals_end_it_too(number: signal.Signals, code: int, tmp_path: Path) -> None:
    assert interrupted(PLAIN, number, tmp_path) == (code, "servosight: interrupted\n")


def test_ignored_signals_stay_ignored() -> None:
    """As under nohup, or in the background of a script."""
    script = (
        "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from servosight.app import interrupt\n"
        "interrupt.install()\n"
        "print(signal.getsignal(signal.SIGINT) is signal.SIG_IGN)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "True\n", done.stderr


def test_native_warnings_stay_off_the_terminal(tmp_path: Path) -> None:
    """A damaged picture: OpenCV and libjpeg warn on the process's own standard error."""
    (tmp_path / "a.jpg").write_bytes(b"\xff\xd8\xff\xe0\x00\x10JFIF\0" + bytes(300))
    script = (
        "import os, sys; from servosight.app.main import main; from servosight.app.commands import "
        "COMMANDS; COMMANDS['effects'].run = lambda args: os.write(2, b'native') and None; "
        "sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "effects"], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    board = ["calibrate", str(tmp_path / "a.jpg"), "--columns", "9", "--rows", "6"]
    words = [*board, "-o", str(tmp_path / "camera.toml")]
    done = subprocess.run(
        [sys.executable, "-m", "servosight.app", *words], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1, done.stderr
