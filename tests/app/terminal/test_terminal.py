"""What goes to the terminal and to files: JSON, progress, colour."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from servosight.app.terminal import progress, set_amount, write_json
from servosight.models.core import InputError


@contextmanager
def amount(*, quiet: bool = False, verbose: bool = False) -> Iterator[None]:
    """So much is shown within, and as much as usual behind it."""
    set_amount(quiet=quiet, verbose=verbose)
    try:
        yield
    finally:
        set_amount(quiet=False, verbose=False)


def test_json_to_files_and_nowhere(tmp_path: Path) -> None:
    write_json(None, {})
    write_json(str(tmp_path / "a.json"), {"a": 1})
    assert json.loads((tmp_path / "a.json").read_text()) == {"a": 1}
    with pytest.raises(InputError, match="cannot be written"):
        write_json(str(tmp_path / "no" / "a.json"), {})
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.json"]


class Terminal:
    """A standard error that claims to be a terminal and keeps what it is told."""

    encoding = "utf-8"

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        pass


def test_progress_is_shown_on_a_terminal_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with progress("work") as show:
        show("step", 1, 2)
    assert capsys.readouterr() == ("", "")
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress("work") as show:
        show("step", 1, 2)
    assert "work: step" in terminal.text
    assert "1/2" in terminal.text


def test_progress_leaves_the_terminal_to_a_question(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress("work") as show:
        show("step", 1, 2)
        with show.hidden():
            before = terminal.text
            show("asked", 1, 2)
            assert terminal.text == before
        assert "work: asked" in terminal.text


def test_verbose_says_what_took_how_long(capsys: pytest.CaptureFixture[str]) -> None:
    with amount(verbose=True), progress("diagnosing") as show:
        show("1 frames/s", 1, 2)
        show("2 frames/s", 2, 2)
        show("trying backlash", 0, 1)
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = [re.sub(r"\d+\.\d s$", "N s", line) for line in captured.err.splitlines()]
    assert lines == ["diagnosing ...", "  trying backlash: N s", "diagnosing: N s"]


BEST = "best so far: backlash, 0.412 deg rms on validation data, 3.4 times the floor of 0.120 deg"


def searching() -> None:
    """A search that finds something and is interrupted."""
    with progress("diagnosing") as show:
        show(BEST, 0)
        show("effect 3: tried all", 26, 26)
        raise KeyboardInterrupt


@pytest.mark.parametrize("verbose", [False, True])
def test_the_best_so_far_is_a_line_and_is_told_when_interrupted(
    verbose: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    with amount(verbose=verbose), pytest.raises(KeyboardInterrupt):
        searching()
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert lines.count(BEST) == 1
    (last,) = (line for line in lines if line.startswith("interrupted"))
    assert last.startswith(f"interrupted, {BEST}; this is not a finished diagnosis")


def test_quiet_says_nothing_of_it(capsys: pytest.CaptureFixture[str]) -> None:
    with amount(quiet=True), pytest.raises(KeyboardInterrupt):
        searching()
    assert capsys.readouterr() == ("", "")


def test_a_terminal_of_80_columns_shows_the_stage_its_count_and_the_best(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    for name, value in (("TERM", "xterm"), ("COLUMNS", "80"), ("NO_COLOR", "1")):
        monkeypatch.setenv(name, value)
    with progress("diagnosing") as show:
        show(BEST, 0)
        show("in place of directional friction: tried all", 26, 26)
    plain = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", terminal.text)
    lines = [line.strip() for line in re.split(r"[\r\n]+", plain)]
    assert any(line.endswith("26/26") and "tried all" in line for line in lines)
    assert BEST in " ".join(lines)


@pytest.mark.parametrize("given", [{"NO_COLOR": "1"}, {"TERM": "dumb"}, {}])
def test_no_colour_where_none_is_wanted(
    given: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """https://no-color.org: without it, the bar of a terminal is coloured."""
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in ({"TERM": "xterm-256color"} | given).items():
        monkeypatch.setenv(name, value)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress("work") as show:
        show("step", 1, 2)
    coloured = re.search(r"\x1b\[[\d;]*3\d", terminal.text) is not None
    assert coloured == (not given)
