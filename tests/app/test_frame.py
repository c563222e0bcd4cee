"""The command line's frame: help, exit codes, one sentence for what goes wrong."""

from __future__ import annotations

import argparse
import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from servosight import __version__
from servosight.app.commands import COMMANDS
from servosight.app.main import main
from servosight.app.parser import parser
from servosight.models.core import InputError
from servosight.models.effects import catalogue

NAMES = [
    *("demo", "simulate", "import", "track", "identify", "compare", "diagnose", "add", "effects"),
    "predict",
]
HEAVY = ("numpy", "scipy", "numba", "rich", "mujoco", "cv2", "av", "matplotlib", "OpenGL")


def said(capsys: pytest.CaptureFixture[str], code: int, words: list[str]) -> str:
    """Run a command that must leave with ``code`` and one line on standard error; the line."""
    assert main(words) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("servosight: ")
    assert captured.err.count("\n") == 1, captured.err
    return captured.err


def raising(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Make ``servosight effects`` fail with ``error``."""

    def run(args: argparse.Namespace) -> None:
        raise error

    monkeypatch.setattr(COMMANDS["effects"], "run", run)


def test_help_names_the_commands_and_loads_nothing_heavy() -> None:
    script = (
        "import sys; from servosight.app.main import main; code = main(['--help']); "
        f"print('HEAVY', [name for name in {HEAVY!r} if name in sys.modules], code)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.endswith("HEAVY [] 0\n"), done.stdout + done.stderr
    for name in NAMES:
        assert name in done.stdout


@pytest.mark.parametrize(("told", "kept"), [(None, "1"), ("2", "2")])
def test_the_simulations_threads_have_the_cores_unless_told_otherwise(
    told: str | None, kept: str
) -> None:
    script = (
        "import os; from servosight.app.main import main; main(['--version']); "
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    settings = {name: x for name, x in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    settings |= {} if told is None else {"OPENBLAS_NUM_THREADS": told}
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, env=settings)
    assert done.stdout.splitlines()[-1] == kept, done.stderr


def test_no_context_of_mujoco_is_asked_for(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "servosight.app", "simulate", "-q", "-o", str(tmp_path / "run")]
    settings = os.environ | {"MUJOCO_GL": "none of its names"}  # MuJoCo would end in an error
    done = subprocess.run(words, capture_output=True, text=True, env=settings)
    assert done.returncode == 0, done.stderr


def unread(words: list[str], place: Path) -> subprocess.CompletedProcess[bytes]:
    """Run a command on a log, its output into a pipe that nobody reads, as behind ``| head``."""
    rows = [f"{0.02 * i:.2f},{i // 20 % 2},{i // 20 % 2}" for i in range(200)]
    (place / "log.csv").write_text("\n".join(["time_s,command_deg,angle_deg", *rows]))
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "servosight.app", *words]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, cwd=place)
    os.close(writing)
    return done


def test_files_are_written_though_nobody_reads_the_output(tmp_path: Path) -> None:
    words = ["identify", "log.csv", "--method", "gradient", "--json", "found.json"]
    done = unread(words, tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert "k" in json.loads((tmp_path / "found.json").read_text())["parameters"]


def test_a_report_is_written_though_nobody_reads_the_json(tmp_path: Path) -> None:
    words = ["diagnose", "log.csv", "-q", "--json", "-", "--report", "report.html"]
    done = unread(words, tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert "</html>" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    assert "usage: servosight" in capsys.readouterr().out


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("servosight 0.")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], "required: COMMAND"),
        (["workbench"], "invalid choice: 'workbench'"),
        (["diagnos"], "did you mean diagnose?"),
        (["diagnose"], "required: REC"),
        (["diagnose", "rec", "--seed", "-1"], "whole number"),
        (["diagnose", "rec", "--seed", "x"], "whole number"),
        (["diagnose", "rec", "--tolerance", "-1"], "degrees from 0"),
        (["diagnose", "rec", "--tolerance", "1e308"], "degrees from 0 to 1e+06"),
        (["diagnose", "rec", "--tolerance", "nan"], "not finite"),
        (["diagnose", "rec", "--fast"], "--fast"),
        (["identify", "rec", "--deg-per-us", "x"], "'x' is no number"),
        (["track", "rec", "--pivot", "3"], "X,Y"),
        (["track", "rec", "--template", "1,2,3"], "X,Y,W,H"),
        (["track", "rec", "--method", "guess"], "refine, match, marker"),
        (["import", "log.csv"], "required: -o"),
    ],
)
def test_wrong_usage(words: list[str], expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert expected in said(capsys, 2, words)


@pytest.mark.parametrize(
    "words",
    [
        ["identify", "rec", "--json"],
        ["identify", "rec", "-o"],
        ["compare", "model.toml"],
        ["simulate", "-o"],
        ["track"],
        ["effects", "--plugin"],
    ],
)
@pytest.mark.parametrize("name", ["a\0b", "x" * 300, "y/" * 3000])
def test_names_that_no_file_can_have(
    name: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    sentence = said(capsys, 2, [*words, name])
    assert "cannot be opened" in sentence
    assert len(sentence) < 400


def test_bad_input_leaves_with_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    raising(monkeypatch, InputError("log.csv, row 3: bad\nnews"))
    assert said(capsys, 2, ["effects"]) == "servosight: log.csv, row 3: bad news\n"


def test_errors_of_the_program_leave_with_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    raising(monkeypatch, ZeroDivisionError("by zero"))
    sentence = said(capsys, 1, ["effects"])
    assert "ZeroDivisionError: by zero" in sentence
    assert "--debug" in sentence


def test_an_interrupt_leaves_with_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    raising(monkeypatch, KeyboardInterrupt())
    assert "interrupted" in said(capsys, 130, ["effects"])


@pytest.mark.parametrize("words", [["--debug", "effects"], ["effects", "--debug"]])
@pytest.mark.parametrize(("error", "code"), [(InputError("bad"), 2), (ValueError("bad"), 1)])
def test_debug_shows_the_traceback(
    words: list[str],
    error: Exception,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    raising(monkeypatch, error)
    assert main(words) == code
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["-q", "effects"], ["effects", "--quiet"]])
def test_general_options_stand_on_either_side_of_the_command(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "near"),
    [
        ("trak film.mkv", "did you mean track?"),
        ("track --metod match film.mkv", "(did you mean --method?); see `servosight track --help`"),
        ("--verbos effects", "did you mean --verbose?"),
        ("identify run.csv --method pos", "did you mean pso?"),
        ("excite standrd -o command.csv", "did you mean standard?"),
    ],
)
def test_a_misspelt_word_is_told_the_nearest(
    words: str, near: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert near in said(capsys, 2, words.split())


def test_an_option_like_no_other_is_told_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean" not in said(capsys, 2, ["identify", "run.csv", "--tolerance", "3"])


def test_a_second_value_is_told_to_repeat_the_option(capsys: pytest.CaptureFixture[str]) -> None:
    told = said(capsys, 2, ["diagnose", "a", "--validate", "b", "c", "d"])
    assert (
        "unrecognized arguments: c d; repeat the option for each: --validate b --validate c" in told
    )


def test_a_value_behind_an_option_that_takes_none_is_told_what_that_does(
    capsys: pytest.CaptureFixture[str],
) -> None:
    told = said(capsys, 2, ["track", "fin.mp4", "--draw", "sheet.png"])
    assert "unrecognized arguments: sheet.png; --draw takes no value (both, as track_ove" in told
    assert "takes no value" not in said(capsys, 2, ["track", "fin.mp4", "--draw", "--sheat"])


def test_recordings_also_stand_behind_options() -> None:
    words = ["diagnose", "a", "--auto", "b", "--json", "-", "c"]
    assert parser().parse_args(words).recordings == [Path("a"), Path("b"), Path("c")]


def test_a_recording_behind_an_option_is_checked_as_others_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert "no file name can have" in said(capsys, 2, ["diagnose", "a", "--auto", "b\0"])


def test_exit_code_of_the_process(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "servosight.app", "identify", str(tmp_path / "nothing")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("servosight: ")
    assert done.stderr.count("\n") == 1


def test_a_reader_that_leaves_early_is_no_error() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "servosight.app", "effects"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    complaint = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 0, complaint
    assert complaint == b""


def test_python_runs_the_package() -> None:
    words = [sys.executable, "-m", "servosight", "--version"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.stdout == f"servosight {__version__}\n"


def test_effects_on_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--list"]) == 0
    names, lines = list(catalogue()), capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == names
    assert len(lines) == len(names) + 1


def test_quiet_prints_json_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "backlash", "--quiet", "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["effects"][0]["id"] == "backlash"
    assert captured.err == ""


@pytest.mark.parametrize(
    "words",
    [
        ["effects", "baklash"],
        ["simulate", "--effect", "baklash", "-o", "rec"],
        ["identify", "rec.csv", "--effects", "coulomb_friction,baklash"],
    ],
)
def test_a_misspelt_effect_is_guessed(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean backlash?" in said(capsys, 2, words)


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["diagnose", "rec", "--json"], "FILE (write the result as JSON; - for standard output)"),
        (["track", "fin.mkv", "-o"], "angle.csv (default: into the recording)"),
        (["track", "fin.mkv", "--marker"], "aruco|apriltag (follow a marker"),
    ],
)
def test_an_option_without_its_value_says_what_it_takes(
    words: list[str], wanted: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert f"expected one argument, {wanted}" in said(capsys, 2, words)


def test_verbose_and_quiet_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert "not allowed with" in said(capsys, 2, ["effects", "-q", "-v"])


def completed(line: str, place: Path) -> list[str]:
    """What a shell is told for a line that is typed so far."""
    told = place / "told"
    environment = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(told),
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    words = [sys.executable, "-m", "servosight"]
    subprocess.run(words, env=os.environ | environment, check=True, capture_output=True)
    return told.read_text(encoding="utf-8").split("\n")


def test_a_shell_completes_commands_options_and_names(tmp_path: Path) -> None:
    assert completed("servosight dia", tmp_path) == ["diagnose"]
    assert completed("servosight track --meth", tmp_path) == ["--method"]
    assert completed("servosight effects backl", tmp_path) == ["backlash"]
    words = "servosight identify run7 --effects dead_time,backl"
    assert completed(words, tmp_path) == ["dead_time,backlash"]
    assert completed("servosight bench reh", tmp_path) == ["rehearse"]
    assert completed("servosight export model.toml --to fm", tmp_path) == ["fmu", "fmu2"]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("diagnose", "has no effect: the selection is deterministic"),
        ("identify", "(default: 0)"),
        ("demo", "(default: 1)"),
        ("simulate", "(default: the scenario's)"),
        ("calibrate", "a square's side (default: 10)"),
    ],
)
def test_help_says_what_holds_without_an_option(
    command: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, "--help"]) == 0
    assert words in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    assert "_ARGCOMPLETE" in capsys.readouterr().out


def test_long_words_are_shortened(capsys: pytest.CaptureFixture[str]) -> None:
    assert len(said(capsys, 2, ["effects", "y" * 5000])) < 2000


@pytest.mark.parametrize("reason", [errno.ENOSPC, errno.EFBIG])
def test_a_full_disk_is_no_error_of_the_program(
    reason: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where a library writes what it has compiled and names no file."""
    raising(monkeypatch, OSError(reason, os.strerror(reason)))
    line = said(capsys, 2, ["effects"])
    assert f"room on its disk ({os.strerror(reason)})" in line
    raising(monkeypatch, OSError(errno.EIO, os.strerror(errno.EIO)))
    assert "error of the program" in said(capsys, 1, ["effects"])
