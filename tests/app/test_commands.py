"""Each command through the command line: what it reads, writes and says."""

from __future__ import annotations

import importlib
import json
import math
import re
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Actuator, Estimate, FrameProgress
from servosight.models.effects import catalogue
from servosight.models.effects._registry import CATALOGUE
from servosight.models.io import load_recording
from servosight.sources import geometry_of
from servosight.tracking.core import Flag, Shutters, Track, TrackOptions

T, XI = 0.05, 0.7


def response(t: float, rate: float) -> float:
    """Exact answer of G(s) with k = 1, T and XI to sin(rate t), once it has settled."""
    gain = 1.0 / complex(1.0 - (T * rate) ** 2, 2.0 * XI * T * rate)
    return abs(gain) * math.sin(rate * t + math.atan2(gain.imag, gain.real))


def log(path: Path, header: str = "time_s,command_deg,angle_deg", change: str = "") -> Path:
    """Two settled sines, exact to 1e-6 deg: linear between rows, so held in a folder."""
    rows = [
        f"{t:.3f},{10 * math.sin(3 * t) + 5 * math.sin(11 * t):.6f},"
        f"{10 * response(t, 3) + 5 * response(t, 11):.6f}"
        for t in (0.01 * i for i in range(300))
    ]
    if change:
        rows[5] = change
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def recording(place: Path) -> Path:
    """A folder with a linear command, so that the sines are what the servo was told."""
    place.mkdir(parents=True)
    lines = [line.split(",") for line in log(place / "all.csv").read_text().splitlines()]
    (place / "all.csv").unlink()
    (place / "recording.toml").write_text('format = 1\nhold = "linear"\n')
    (place / "command.csv").write_text("".join(f"{t},{u}\n" for t, u, _ in lines))
    (place / "angle.csv").write_text("".join(f"{t},{y}\n" for t, _, y in lines))
    return place


def complaint(capsys: pytest.CaptureFixture[str], words: list[str], *expected: str) -> None:
    """The command leaves with 2 and one sentence that holds all of ``expected``."""
    assert main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    for word in expected:
        assert word in captured.err, captured.err


# --- identify, compare ----------------------------------------------------------------------


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

    assert main(["compare", str(card), str(rec), "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["rmse_deg"] < 0.05
    assert "fit (NRMSE) 9" in captured.err
    assert "Next:" in captured.err


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


# --- diagnose and add, with the fit replaced --------------------------------------------------

ACTUATOR = Actuator(
    {
        "k": Estimate(1.0, 0.001, "-"),
        "T": Estimate(0.02, 0.001, "s"),
        "xi": Estimate(0.6, None, "-"),
        "bias": Estimate(0.0, 0.01, "deg"),
    }
)


def values_of(auto: bool) -> dict[str, Any]:
    """A diagnosis in the form that is fixed."""
    parameters: dict[str, Any] = {name: one.to_json() for name, one in ACTUATOR.parameters.items()}
    parameters["bias"] = [parameters["bias"], parameters["bias"]]
    rungs = [(None, 0.6, False)] + [("backlash", 0.032, True)] * auto
    return {
        "schema": 1,
        "noise_deg": 0.031,
        "floor_deg": 0.032,
        "verdict": "explained" if auto else "unexplained",
        "headline": "What was missing: backlash",
        "summary": "Its error falls.",
        "effects": ["backlash"] * auto,
        "ladder": [
            {
                "added": added,
                "base": "linear",
                "effects": [added] if added else [],
                "train_rmse_deg": error,
                "validation_rmse_deg": error,
                "held_out_rmse_deg": error,
                "explained": explained,
                "parameters": parameters,
                "fit_percent": 100.0 - 10.0 * error,
                "held": ["k held at 1 from here"] if added else [],
            }
            for added, error, explained in rungs
        ],
        "candidates": [
            {
                "effect": "backlash",
                "held_out_rmse_deg": 0.032,
                "evidence": 812.4,
                "confounded_with": ["dead_zone"],
            }
        ],
        "where": [
            {
                "recording": "log",
                "start_s": 3.1,
                "end_s": 3.4,
                "rmse_deg": 1.9,
                "share": 0.22,
                "what": "high_frequency",
            }
        ],
        "next_experiment": "Record triangles at two amplitudes.",
    }


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Replace diagnosis, addition and report; gives what they were asked."""
    kept: dict[str, Any] = {}

    def diagnose(recordings: Any, validate: Any = (), test: Any = (), **options: Any) -> Any:
        kept.update(options, recordings=recordings, validate=validate, test=test)
        values = values_of(options["auto"])
        return SimpleNamespace(
            actuator=ACTUATOR, law=None, proposal=None, known_effects=None, to_dict=lambda: values
        )

    def add(actuator: Actuator, effect: str, recordings: Any, **options: Any) -> Any:
        kept.update(options, actuator=actuator, effect=effect, recordings=recordings)
        values = {
            **values_of(True),
            "parameters": {},
            "rmse_deg": 0.1,
            "fit_percent": 98.7,
            "samples": 300,
            "method": "gradient",
            "seconds": 0.1,
            "stopped": "converged",
            "warnings": ["xi: one frequency cannot tell it"],
        }
        return SimpleNamespace(actuator=ACTUATOR, to_dict=lambda: values)

    def write_report(path: Path, result: Any, recordings: Any, *rest: Any, **options: Any) -> None:
        path.write_text(f"{len(recordings)} recordings")

    for module, name, function in (
        ("servosight.diagnose", "diagnose", diagnose),
        ("servosight.diagnose", "add", add),
        ("servosight.app.report", "write_report", write_report),
    ):
        monkeypatch.setattr(importlib.import_module(module), name, function)
    return kept


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
        "0.032 deg",
        "fit (NRMSE) of the last model on test data: 99.68 %",
        "█",
        "+ backlash: k held at 1 from here",
        "What was missing: backlash. Its error falls.",
        "high frequency",
        "dead_zone",
        "bias (2)",
        "not known",
        "two amplitudes",
        "Next: servosight compare",
    ):
        assert word in told, told


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


# --- effects ----------------------------------------------------------------------------------


def test_effects_show_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    told = capsys.readouterr().out
    for name in CATALOGUE:
        assert f"{name}  (" in told
    assert main(["effects", "rate_limit"]) == 0
    told = capsys.readouterr().out
    for word in ("equation", "vanishes at infinity", "deg/s", "looks like", "confirm", "cause"):
        assert word in told
    assert "backlash  (" not in told


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


# --- import -----------------------------------------------------------------------------------


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
    complaint(capsys, ["import", str(source), "-o", str(tmp_path / "r")], "--map time=COLUMN")
    complaint(capsys, [*words, "--unit-scale", "0"], "--unit-scale 0", "expected")
    complaint(capsys, ["import", "none.json", "-o", "r"], "none.json", "no such file")
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


# --- simulate, track, demo ----------------------------------------------------------------------


def test_simulate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = tmp_path / "s.toml"
    scenario.write_text("duration_s = 2.0\n")
    words = ["simulate", str(scenario), "--set", "backlash.gap=1.5", "--seed", "3"]
    for name in ("a", "b"):
        assert main([*words, "-o", str(tmp_path / name)]) == 0
    assert "hidden: backlash" in capsys.readouterr().out
    for name in ("command.csv", "angle.csv", "recording.toml", "truth.toml"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    complaint(capsys, [*words, "--effect", "magic", "-o", str(tmp_path / "c")], "magic")
    complaint(capsys, [*words, "--set", "gap", "-o", str(tmp_path / "c")], "--set gap")
    complaint(capsys, ["simulate", "no.toml", "-o", str(tmp_path / "c")], "no.toml")
    assert not (tmp_path / "c").exists()


@pytest.fixture
def tracker(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """A tracker that sees the settled sines in any video; gives what it was asked."""
    kept: dict[str, Any] = {}

    def track(video: Path, options: TrackOptions, *, progress: FrameProgress) -> Track:
        kept.update(vars(options), video=video)
        told = options.exposure_s is not None
        progress(300, 300)
        time_s = 0.01 * np.arange(300)
        angle = np.array([10 * response(t, 3) + 5 * response(t, 11) for t in time_s])
        measured = ~np.isin(np.arange(300), (150, 151))
        return Track(
            video=video,
            method="refine",
            time_s=time_s,
            angle_deg=angle,
            sigma_deg=np.where(measured, 0.001, 8.0),
            flags=np.where(measured, Flag.NONE, Flag.LOST).astype(np.uint8),
            pivot_px=(320.5, 240.25),
            template_px=(300, 150, 40, 40),
            outline_px=np.array([[300.0, 200.0], [340.0, 200.0], [320.0, 100.0]]),
            shared_deg=1e-4 * (angle - angle[0])[:, None],
            shutters=Shutters(np.array([0.003]), 0.0, 1e-4, None if told else "found"),
        )

    monkeypatch.setattr("servosight.tracking.acquisition.find_light", lambda *known, **more: None)
    monkeypatch.setattr("servosight.tracking.track.track", track)
    return kept


def filmed(place: Path, settings: str = "") -> Path:
    """A recording with a video in place of its angle."""
    (recording(place) / "angle.csv").unlink()
    (place / "video.mkv").write_bytes(b"")
    (place / "recording.toml").write_text(settings)
    return place


def test_track_a_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], tracker: dict[str, Any]
) -> None:
    rec = filmed(
        tmp_path / "rec", "video_offset_s = 0.5\n[camera]\nexposure_s = 0.004\nreadout_s = 0.002\n"
    )
    assert main(["track", str(rec), "--pivot", "3,4", "--method", "match"]) == 0
    told = capsys.readouterr().out
    assert "300 frames" in told
    assert "2 frames left out" in told
    assert tracker["pivot"] == (3.0, 4.0)
    assert tracker["method"] == "match"
    assert (tracker["exposure_s"], tracker["readout_s"]) == (0.004, 0.002)
    rows = (rec / "angle.csv").read_text().splitlines()
    assert rows[0] == "time_s,angle_deg,sigma_deg"
    assert rows[1].startswith("0.5,")  # the offset; the tracker's times are the middle row's
    # What was not seen leaves neither a row nor its doubt, which would count as noise.
    assert len(rows) == 1 + 298
    assert all(row.endswith(",0.001") for row in rows[1:])
    read = load_recording(rec)
    assert read.shared_deg is not None
    assert read.shared_deg[:, 0] == pytest.approx(1e-4 * (read.angle_deg - read.angle_deg[0]))
    kept = geometry_of(read)
    assert kept is not None
    assert [kept.frame_of(row) for row in (0, 149, 150, 297)] == [0, 149, 152, 299]
    whole = (rec / "track.toml").read_text()
    for damaged in ("[150, 1000]", "[-1, 150]", "[150, 150]", '"no"', "[150, 1e400]"):
        (rec / "track.toml").write_text(whole.replace("[150, 151]", damaged))
        assert geometry_of(read) is None
    (rec / "video.mkv").unlink()
    complaint(capsys, ["track", str(rec)], "holds no video", "expected")


def test_an_exposure_that_is_not_told_is_found_and_kept(
    tmp_path: Path, tracker: dict[str, Any]
) -> None:
    rec = filmed(tmp_path / "rec")
    for _ in range(2):
        assert main(["track", str(rec)]) == 0
        assert tracker["exposure_s"] is None
        assert load_recording(rec).exposure_s == pytest.approx(0.003)
    with (rec / "recording.toml").open("a") as file:
        file.write("[camera]\nexposure_s = 0.004\n")
    assert main(["track", str(rec)]) == 0
    assert tracker["exposure_s"] == 0.004
    assert load_recording(rec).exposure_s == 0.004


def test_track_a_bare_video(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], tracker: dict[str, Any]
) -> None:
    video = tmp_path / "clip.mp4"
    video.write_bytes(b"")
    assert main(["track", str(video), "--alone", "-o", str(tmp_path / "a.csv")]) == 0
    assert (tmp_path / "a.csv").read_text().splitlines()[1].startswith("0.0,")
    assert main(["track", str(video), "--alone"]) == 0
    assert (tmp_path / "angle.csv").exists()


def test_whoever_needs_the_angle_tracks_first(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    tracker: dict[str, Any],
    asked: dict[str, Any],
) -> None:
    rec = filmed(tmp_path / "rec")
    assert main(["diagnose", str(rec)]) == 0
    assert asked["recordings"][0].sigma_deg[0] == 0.001
    assert (rec / "angle.csv").exists()
    tracker.clear()
    assert main(["diagnose", str(rec)]) == 0
    assert tracker == {}


def test_track_a_file_that_is_no_video(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    complaint(capsys, ["track", str(tmp_path / "no.mkv")], "no.mkv", "no such file")
    (tmp_path / "a.mkv").write_bytes(b"junk" * 100)
    complaint(capsys, ["track", str(tmp_path / "a.mkv")], "a.mkv", "expected")
    assert not (tmp_path / "angle.csv").exists()


def test_demo_writes_its_four_parts(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    tracker: dict[str, Any],
    asked: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def produce(scenario: Any, folder: Path, progress: Any, *, force: bool) -> None:
        filmed(folder)
        progress(1, 1)

    module = "servosight.scenarios.produce"
    monkeypatch.setitem(sys.modules, module, SimpleNamespace(produce=produce))
    place = tmp_path / "out" / "demo"
    assert main(["demo", "-o", str(place), "--seed", "5"]) == 0
    names = sorted(entry.name for entry in place.iterdir())
    assert names == ["diagnosis.json", "model.toml", "recording", "report.html"]
    assert json.loads((place / "diagnosis.json").read_text()) == values_of(True)
    told = capsys.readouterr().out
    assert "seed 5" in told
    assert "What was hidden" in told
    assert asked["auto"] is True
