"""diagnose and add through the command line, with the fit replaced."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from support.commands import ACTUATOR, complaint, log, values_of

from servosight.app.main import main


def test_diagnose_tells_the_story(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: dict[str, Any]
) -> None:
    one, two = str(log(tmp_path / "one.csv")), str(log(tmp_path / "two.csv"))
    card, report = tmp_path / "m.toml", tmp_path / "r.html"
    words = ["diagnose", one, "--validate", two, "--auto", "--tolerance", "0.02"]
    assert main([*words, "-o", str(card), "--report", str(report)]) == 0
    assert [rec.name for rec in asked["recordings"]] == ["one"]
    assert [rec.name for rec in asked["validate"]] == ["two"]
    assert asked["tolerance"] == 0.02
    assert report.read_text() == "2 recordings"
    assert tomllib.loads(card.read_text())["format"] == 1
    told = capsys.readouterr().out
    for word in (
        "linear",
        "+ backlash",
        "0.0320 deg",
        "fit (NRMSE) of the last model on test data: 99.68 %",
        "█",
        "+ backlash: k held at 1 from here",
        "What was missing: backlash. Its error falls.",
        "high frequency",
        "dead_zone",
        "bias (2)",
        "not known",
        "note: xi: its sigma is not known",
        "each effect alone added to the linear model; evidence above 10 excludes chance",
        "+812",
        "where the linear model fails; share of its squared error",
        "two amplitudes",
        "Next: servosight compare",
    ):
        assert word in told, told
    assert "note: k held" not in told


def test_what_a_search_found_is_saved_before_the_report_is_written(
    tmp_path: Path, asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_report(*_: Any, **__: Any) -> None:
        raise RuntimeError

    monkeypatch.setattr("servosight.app.report.write_report", no_report)
    words = ["diagnose", str(log(tmp_path / "log.csv")), "--auto"]
    found = tmp_path / "found.json"
    assert main([*words, "--json", str(found), "--report", str(tmp_path / "r.html")]) == 1
    assert json.loads(found.read_text()) == values_of(True)


def test_diagnose_without_auto_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: dict[str, Any]
) -> None:
    assert main(["diagnose", str(log(tmp_path / "log.csv")), "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out) == values_of(False)
    assert re.search(r"Next: servosight diagnose .*log.csv --auto", captured.err)
    assert asked["auto"] is False


def test_add(tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: dict[str, Any]) -> None:
    rec, card, new = str(log(tmp_path / "log.csv")), tmp_path / "m.toml", tmp_path / "n.toml"
    ACTUATOR.save(card)
    before = card.read_bytes()
    assert main(["add", str(card), "backlash", rec]) == 0
    assert "unchanged" in capsys.readouterr().out
    assert card.read_bytes() == before
    assert main(["add", str(card), "backlash", rec, "-o", str(new)]) == 0
    told = capsys.readouterr().out
    assert "note: xi" in told
    assert new.exists()
    assert asked["effect"] == "backlash"
    complaint(capsys, ["add", str(card), "magic", rec], "magic", "backlash")
