"""servosight sweep and results, and their verbs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import servosight as ss
from servosight.app.main import main
from servosight.app.sweeps import draw
from servosight.models.core import InputError, Kind, Table, kind_of
from servosight.scenarios.sweeps import Summary
from servosight.scenarios.sweeps.measure import CellWork
from servosight.scenarios.sweeps.run import Store

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
    again = "servosight sweep sweep.toml -o out --workers 0"
    assert said.count(f"1 of 2 cells are done; to go on: {again}\n") == 1
    assert ss.results("out").height == 1


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["sweep", "no.toml", "-o", "out"], "no such file"),
        (["sweep", "resolutoin", "-o", "out"], "did you mean resolution?"),
        (["sweep", "sweep.toml", "-o", "sweep.toml"], "is a file"),
        (["sweep", "sweep.toml", "-o", "out", "--workers", "-1"], "expected 0 to 10000"),
        (
            ["sweep", "sweep.toml", "-o", "out", "--workers", "2", "--scheduler", "tcp://h:1"],
            "the workers are those of --scheduler",
        ),
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


def filled(folder: Path, axes: list[str]) -> None:
    """A folder as a sweep leaves it, over two axes, with diagnoses and one hostile text."""
    store = Store(folder)
    found = {
        "name": "s", "about": "</script><b>&", "axes": axes, "cells": 12, "made": "m",
        "seeds": [0, 1], "recipe": {},
    }  # fmt: skip
    with store.opened(found):
        for number in range(12):
            gap, noise = (0.1, 0.3, 0.9)[number % 3], (0.01, 0.1)[number // 3 % 2]
            row = {
                "cell": f"{number:032x}", "made": "m", "status": "done", "error": None,
                "noise_deg": noise, "effects.backlash.gap": gap, "seed": number // 6,
                "effects": ["backlash"] if gap > 3.0 * noise else [], "named": gap > 3.0 * noise,
                **{f"{p}_{e}": noise * 0.01 for p in ("k", "T", "xi") for e in ("error", "bound")},
                "seconds": 1.0,
            }  # fmt: skip
            (store.cells / f"{number:032x}.json").write_text(json.dumps(row))
        store.tidy()


def test_a_sweep_is_drawn(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    filled(place / "out", ["noise_deg", "effects.backlash.gap"])
    for name in ("maps.png", "page.html"):
        assert main(["results", "out", "--plot", name]) == 0
    said = capsys.readouterr().out
    assert "noise_deg 0.01: smallest backlash gap found in 95 % of recordings" in said
    assert kind_of(place / "maps.png") is Kind.PNG
    assert kind_of(place / "page.html") is Kind.HTML
    page = (place / "page.html").read_text()
    assert page.count("</script>") == 2  # a text of the sweep ends no script
    assert not re.search(r"(src|href)\s*=|https?://(?!www\.w3\.org/2000/svg)", page)
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])  # type: ignore[index]
    assert data["about"] == "</script><b>&"
    assert len(data["table"]) == 6
    assert data["joint"] == [["noise_deg"], ["effects.backlash.gap"]]

    (place / "mine.png").write_bytes(b"years of work")
    for name, words in (("mine.png", "--force"), ("a.gif", "expected .png or .html")):
        assert main(["results", "out", "--plot", name]) == 2
        assert words in capsys.readouterr().err


def summary_over(axes: dict[str, list[float]]) -> Summary:
    """A summary whose settings are the rows of ``axes``."""
    rows = [dict(zip(axes, values, strict=True)) for values in zip(*axes.values(), strict=True)]
    errors = {f"{p}_{e}": 0.01 for p in ("k", "T", "xi") for e in ("error", "bound")}
    return Summary(
        schema=1, name="s", about="", axes=tuple(axes), cells=len(rows), planned=len(rows),
        failed=0, left_out=0, kinds={}, found=Table(),
        table=Table([{**row, "cells": 1, **errors, "rare_error": None} for row in rows]),
    )  # fmt: skip


DRAWN = {"noise_deg": [0.1 + n for n in range(60)], "T": [float(n * 7 % 60) for n in range(60)]}


@pytest.mark.parametrize(
    ("axes", "joint"),
    [
        ({"noise_deg": [0.1, 1.0]}, [["noise_deg"]]),
        (
            {"width": [160, 160, 320, 320], "height": [120, 120, 240, 240], "crf": [9, 8, 9, 8]},
            [["width", "height"], ["crf"]],
        ),
        (DRAWN, [["noise_deg"], ["T"]]),
        ({"crf": [9, 8], "width": [320, 320], "height": [240, 240]}, [["crf"]]),
        ({"crf": [9], "width": [320]}, [["crf"]]),
    ],
)
def test_keys_that_change_together_are_one_axis_of_a_picture(
    axes: dict[str, list[float]], joint: list[list[str]], tmp_path: Path
) -> None:
    found = summary_over(axes)
    for name in ("a.png", "a.html"):
        draw(found, tmp_path / name)
    text = (tmp_path / "a.html").read_text()
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert data["joint"] == joint


def test_too_many_axes_for_a_picture_are_said(tmp_path: Path) -> None:
    axes = {"a": [1.0, 2.0, 1.0, 2.0], "b": [1.0, 1.0, 2.0, 2.0], "c": [1.0, 2.0, 2.0, 1.0]}
    with pytest.raises(InputError, match=r"over one or two axes .*choose \.html"):
        draw(summary_over(axes), tmp_path / "a.png")


def test_a_page_of_very_many_settings_holds_a_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("servosight.app.sweeps.page.MOST_ROWS", 20)
    draw(summary_over(DRAWN), tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert len(data["table"]) == 20
    assert data["headline"].endswith("; one setting in 3 is shown")


def test_a_long_table_is_cut_and_columns_that_few_have_are_left_out(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    filled(place / "out", ["noise_deg", "effects.backlash.gap"])
    monkeypatch.setattr("servosight.app.commands.sweeps.results.LINES", 4)
    monkeypatch.setattr(
        "servosight.scenarios.sweeps.summary", lambda frame, facts: summary_over(DRAWN)
    )
    assert main(["results", "out"]) == 0
    said = capsys.readouterr().out
    assert "... and 56 settings more: --json FILE writes all" in said
    assert "k_error" in said
    assert "rare_error" not in said
