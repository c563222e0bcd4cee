"""import and effects through the command line."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from support.commands import complaint, log

from servosight.app.main import main
from servosight.models.effects import catalogue
from servosight.models.io import load_recording


def test_effects_show_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    told = capsys.readouterr().out
    for name in catalogue():
        assert f"{name}  (" in told
    assert main(["effects", "rate_limit"]) == 0
    told = capsys.readouterr().out
    for word in ("equation", "vanishes at infinity", "deg/s", "looks like", "confirm", "cause"):
        assert word in told
    assert "backlash  (" not in told
    assert main(["effects", "flexible_shaft"]) == 0
    told = capsys.readouterr().out
    assert "    inertia_ratio far inertia over the total, 0 to 0.8\n" in told
    assert "\n  equation        far'' =" in told


PLUGIN = """
from servosight.models.effects import Effect, Place
from servosight.models.core import Parameter

def term(drive: float, w: float, ratio: float) -> float:
    return drive * ratio if drive < 0.0 else drive

EFFECT = Effect(
    id="weak_side", place=Place.DRIVE,
    parameters=(Parameter("ratio", "-", 0.1, 2.0, 1.0, "share"),),
    equation="e", looks_like="l", cause="c", confirm="d", remedy="r", source="s",
    starts=lambda features: ((0.8,),), term=term,
)
"""


def test_effects_with_a_plugin(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.py").write_text(PLUGIN)
    assert main(["effects", "weak_side", "--plugin", str(tmp_path / "mine.py")]) == 0
    assert "weak_side  (drive)" in capsys.readouterr().out
    (tmp_path / "bad.py").write_text("1 / 0")
    complaint(
        capsys, ["effects", "--plugin", str(tmp_path / "bad.py")], "bad.py", "ZeroDivisionError"
    )
    complaint(capsys, ["effects", "--plugin", str(tmp_path / "no.py")], "no.py", "no such")
    complaint(capsys, ["effects", "magic"], "magic", "backlash")


def test_import_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = log(tmp_path / "log.csv", "t,goal,pos")
    words = ["import", str(source), "-o", str(tmp_path / "deep" / "rec"), "--map", "time=t"]
    words += ["--map", "command=goal:rad", "--map", "angle=pos", "--unit", "rad"]
    for more in ([], ["--force"]):  # a second time replaces the first only where it may
        assert main([*words, *more]) == 0
        assert "300 samples" in capsys.readouterr().out
    settings = tomllib.loads((tmp_path / "deep" / "rec" / "recording.toml").read_text())
    assert settings["source"]["name"] == "log.csv"
    (tmp_path / "deep" / "rec" / "video.mkv").write_bytes(b"precious")
    complaint(capsys, [*words, "--force"], "video.mkv", "expected a new or empty folder")
    complaint(capsys, ["import", str(source), "-o", str(tmp_path / "r")], "--map time=t:s")
    complaint(capsys, [*words, "--unit-scale", "0"], "--unit-scale 0", "expected")
    complaint(capsys, ["import", "none.json", "-o", "r"], "none.json", "no such file")
    complaint(capsys, ["import", str(source), "-o", ""], "--output", "is empty")
    complaint(capsys, [*words, "-o", f"{source}/rec"], "cannot be written", "expected")
    assert not (tmp_path / "r").exists()


def test_import_a_command_from_a_table_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, wanted = log(tmp_path / "log.csv", "t,x,pos"), log(tmp_path / "wanted.csv", "t,pos,x")
    words = ["import", str(source), "-o", str(tmp_path / "rec"), "--map", "time=t"]
    words += ["--map", "command=pos", "--map", "angle=pos", "--unit", "rad"]
    assert main([*words, "--command", str(wanted)]) == 0
    assert "300 samples" in capsys.readouterr().out
    complaint(capsys, [*words, "--force", "--command", "none.csv"], "none.csv", "no such file")


def test_import_says_what_the_angle_is_of(tmp_path: Path) -> None:
    words = ["import", str(log(tmp_path / "log.csv", "time_s,command_deg,angle_deg"))]
    assert main([*words, "-o", str(tmp_path / "a"), "--angle-of", "sensor"]) == 0
    assert load_recording(tmp_path / "a").side == "sensor"
    assert main([*words, "-o", str(tmp_path / "b")]) == 0
    assert load_recording(tmp_path / "b").side == "surface"


def test_import_of_a_log_without_torque_says_what_was_cut(
    real_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = real_data / "xl330" / "lift_and_drop_kp100.json"
    assert main(["import", str(source), "-o", str(tmp_path / "rec")]) == 0
    told = capsys.readouterr().out
    assert "torque_enable is false" in told
    assert "372 samples" in told
