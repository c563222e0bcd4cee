"""servosight sweep and results, and their verbs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import servosight as ss
from servosight.app.main import main
from servosight.scenarios.sweeps.measure import CellWork

FILE = """
do = ["identify"]
[scenario]
duration_s = 3.0
[axes]
noise_deg = [0.02, 0.1]
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(FILE)
    return tmp_path


def test_a_sweep_and_its_results(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "sweep.toml", "-o", "out", "--workers", "0"]) == 0
    said = capsys.readouterr().out
    assert "out: 2 cells, 0 of them there before, 2 run now, 0 failed" in said
    assert main(["sweep", "sweep.toml", "-o", "out", "--workers", "0"]) == 0
    assert "2 of them there before, 0 run now" in capsys.readouterr().out

    assert main(["results", "out"]) == 0
    said = capsys.readouterr().out
    assert "sweep: 2 cells over noise_deg" in said
    assert "k_error" in said
    assert main(["results", "out", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["noise_deg"] for row in found["table"]] == [0.02, 0.1]
    assert ss.results("out")["k_error"].abs().to_list()[0] == found["table"][0]["k_error"]


def test_ctrl_c_says_how_to_go_on(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls = []

    def interrupted(work: CellWork, cell: object) -> dict[str, float]:
        calls.append(cell)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return {"k_error": 0.0}

    monkeypatch.setattr(CellWork, "__call__", interrupted)
    assert main(["sweep", "sweep.toml", "-o", "out", "--workers", "0"]) == 130
    said = capsys.readouterr().err
    assert "1 of 2 cells are done; to go on: servosight sweep sweep.toml -o out" in said
    assert ss.results("out").height == 1


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["sweep", "no.toml", "-o", "out"], "no such file"),
        (["sweep", "resolutoin", "-o", "out"], "did you mean resolution?"),
        (["sweep", "sweep.toml", "-o", "sweep.toml"], "is a file"),
        (["sweep", "sweep.toml", "-o", "out", "--workers", "-1"], "expected 0 to 10000"),
        (["sweep", "sweep.toml"], "required: -o"),
        (["results", "."], "holds no sweep.json"),
    ],
)
def test_bad_input(
    words: list[str], expected: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert said.count("\n") == 1
