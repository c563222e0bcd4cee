"""identify and compare through the command line: what they read, write and say."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from support.commands import XI, T, complaint, log, recording

from servosight.app.main import main
from servosight.models.core import Actuator, Estimate
from servosight.models.effects import catalogue


def test_identify_then_compare(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rec, card, result = recording(tmp_path / "rec"), tmp_path / "m.toml", tmp_path / "r.json"
    words = ["identify", str(rec), "--method", "gradient", "-o", str(card), "--json", str(result)]
    assert main(words) == 0
    assert "Next: servosight diagnose" in capsys.readouterr().out
    values = json.loads(result.read_text())
    # Truth k = 1, T = 0.05, xi = 0.7; the rows' six digits and the straight lines between rows
    # 0.01 s apart (error (11 rad/s * 0.01 s)^2 / 8 = 0.15 % of 5 deg) bound the error to 0.5 %.
    for name, truth in (("k", 1.0), ("T", T), ("xi", XI)):
        assert values["parameters"][name]["value"] == pytest.approx(truth, rel=5e-3)
    assert values["schema"] == 1
    assert 98.0 < values["fit_percent"] < 100.0
    assert Actuator.load(card, catalogue()).value("k") == values["parameters"]["k"]["value"]
    complaint(capsys, ["compare", str(result), str(rec)], "r.json: is a fit", "-o MODEL.toml")

    assert main(["compare", str(card), str(rec), "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["rmse_deg"] < 0.05
    assert "fit (NRMSE) 9" in captured.err
    assert "Next:" in captured.err


def test_a_model_with_effects_is_what_the_next_diagnosis_begins_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rec, card = recording(tmp_path / "rec"), tmp_path / "m.toml"
    words = ["identify", str(rec), "--method", "gradient", "--effects", "dead_zone"]
    following = f"Next: servosight diagnose {rec} --from {card} --auto"
    assert main([*words, "-o", str(card)]) == 0
    assert following in capsys.readouterr().out
    assert main(words) == 0  # without a card that holds them
    again = f"Next: servosight diagnose {rec} --with dead_zone --auto"
    assert again in capsys.readouterr().out
    text = card.read_text()
    assert re.search(r"\[parameters.T\]\nvalue = [0-9.]+", text)
    card.write_text(re.sub(r"(\[parameters.T\]\nvalue = )[0-9.]+", r"\g<1>0.2", text))
    assert main(["compare", str(card), str(rec)]) == 0
    assert following in capsys.readouterr().out


def test_a_parameter_held_at_two_values(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["identify", str(log(tmp_path / "log.csv")), "--fix", "k=1", "--fix", "k=2"]
    complaint(capsys, words, "--fix k: is given twice, with 1 and 2")


@pytest.mark.parametrize(
    ("words", "needed"),
    [
        (["identify", "REC", "--parameters", "k"], "--model MODEL.fmu"),
        (["identify", "REC", "--fmu-input", "u"], "--model MODEL.fmu"),
        (["compare", "CARD", "REC", "--fmu-output", "y"], "an FMU as the model"),
        (["diagnose", "REC", "--fmu-input", "u"], "--from MODEL.fmu"),
        (["predict", "CARD", "REC", "-o", "OUT", "--fmu-input", "u"], "an FMU as the model"),
    ],
)
def test_an_option_for_an_fmu_is_refused_without_one(
    words: list[str], needed: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    card, out = tmp_path / "m.toml", tmp_path / "out.csv"
    values = {"k": 1.0, "T": T, "xi": XI, "bias": 0.0}
    Actuator({name: Estimate(value, None, "") for name, value in values.items()}).save(card)
    places = {"REC": str(log(tmp_path / "log.csv")), "CARD": str(card), "OUT": str(out)}
    complaint(capsys, [places.get(word, word) for word in words], "has no effect here", needed)
    assert not out.exists()


@pytest.mark.parametrize("option", [["--method", "pso"], ["--seed", "0"]])
def test_a_global_search_is_refused_for_an_fmu(
    option: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["identify", str(log(tmp_path / "log.csv")), "--model", str(tmp_path / "s.fmu")]
    complaint(capsys, [*words, *option], option[0], "no effect with --model", "leave the other out")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            "0.05,left,1",
            ("log.csv", "row 7", "command_deg", "'left'", "expected a number", "correct"),
        ),
        ("0.05,1,nan", ("log.csv", "row 7", "angle_deg", "expected a finite number", "correct")),
        ("0.04,1,1", ("log.csv", "row 7", "stands still", "expected rising", "delete")),
        ("0.03,1,1", ("log.csv", "row 7", "runs back", "expected rising", "sort")),
        ("0.05,1,1e6", ("log.csv", "row 7", "angle_deg", "expected degrees", "unit")),
        ("0.05,1", ("log.csv", "row 7", "2 fields", "expected 3", "correct")),
    ],
)
@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_bad_rows(
    command: str,
    change: str,
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    complaint(capsys, [command, str(log(tmp_path / "log.csv", change=change))], *words)


def test_radians_under_a_name_in_degrees_are_doubted_not_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: dict[str, Any]
) -> None:
    lines = [line.split(",") for line in log(tmp_path / "log.csv").read_text().splitlines()]
    body = [f"{t},{u},{math.radians(float(y)):.6f}" for t, u, y in lines[1:]]
    (tmp_path / "log.csv").write_text("\n".join([",".join(lines[0]), *body]))
    assert main(["diagnose", str(tmp_path / "log.csv")]) == 0
    assert "if the angle is in radians, name its column angle_rad" in capsys.readouterr().err
    assert main(["diagnose", str(log(tmp_path / "log.csv"))]) == 0
    assert capsys.readouterr().err == ""


def test_bad_columns_and_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(log(tmp_path / "log.csv", "time_s,command_us,angle_deg"))
    complaint(capsys, ["identify", path], "command_us", "--deg-per-us", "--neutral-us")
    path = str(log(tmp_path / "log.csv", "time_s,command_deg,y"))
    complaint(capsys, ["identify", path], "log.csv", "row 1", "angle_deg", "servosight import")
    complaint(capsys, ["identify", str(tmp_path / "no")], "no such file")
    path = str(log(tmp_path / "log.csv"))
    complaint(capsys, ["identify", path, "--method", "luck"], "luck", "combination", "gradient")
    complaint(capsys, ["identify", path, "--effects", "magic"], "magic", "backlash")
    (tmp_path / "clip.mp4").write_bytes(b"\0")
    complaint(capsys, ["identify", str(tmp_path / "clip.mp4")], "clip.mp4", "without its command")


@pytest.mark.parametrize("option", ["-o", "--json"])
def test_outputs_are_checked_before_the_work(
    option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rec = str(tmp_path / "never-read")
    complaint(capsys, ["identify", rec, option, str(tmp_path / "no" / "x")], "does not exist")
    complaint(capsys, ["identify", rec, option, str(tmp_path)], "is a folder")


def test_bad_cards(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rec, card = str(log(tmp_path / "log.csv")), tmp_path / "m.toml"
    complaint(capsys, ["compare", str(card), rec], "m.toml", "no such file")
    card.write_text("format = 7")
    complaint(capsys, ["compare", str(card), rec], "m.toml", "format", "7")
