"""simulate, track and demo through the command line, with the tracker replaced."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.commands import complaint, recording, response, values_of

from servosight.app.main import main
from servosight.models.core import FrameProgress
from servosight.models.io import load_recording
from servosight.sources import geometry_of
from servosight.tracking.core import Flag, Shutters, Track, TrackOptions


def test_simulate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = tmp_path / "s.toml"
    scenario.write_text("duration_s = 2.0\n")
    words = ["simulate", str(scenario), "--set", "backlash.gap=1.5", "--seed", "3"]
    for name in ("a", "b"):
        assert main([*words, "-o", str(tmp_path / name)]) == 0
    assert "hidden: backlash" in capsys.readouterr().out
    for name in ("command.csv", "angle.csv", "recording.toml", "truth.toml"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    several = ["--effect", "backlash,dead_zone", "--effect", "coulomb_friction"]
    assert main([*words, *several, "-o", str(tmp_path / "many")]) == 0
    assert "hidden: backlash, dead_zone, coulomb_friction" in capsys.readouterr().out
    complaint(capsys, [*words, "--effect", "magic", "-o", str(tmp_path / "c")], "magic")
    complaint(capsys, [*words, "--set", "gap", "-o", str(tmp_path / "c")], "--set gap")
    complaint(capsys, ["simulate", "no.toml", "-o", str(tmp_path / "c")], "no.toml")
    assert not (tmp_path / "c").exists()


@pytest.fixture
def tracker(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """A tracker that sees the settled sines in any video; gives what it was asked."""
    kept: dict[str, Any] = {}

    def track_film(film: Any, options: TrackOptions, progress: FrameProgress) -> Track:
        lost = kept.pop("lost", ())
        kept.update(vars(options), video=film.path)
        told = options.exposure_s is not None
        progress(300, 300)
        time_s = 0.01 * np.arange(300)
        angle = np.array([10 * response(t, 3) + 5 * response(t, 11) for t in time_s])
        measured = ~np.isin(np.arange(300), (150, 151))
        return Track(
            video=film.path,
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
            lost=lost,
        )

    monkeypatch.setattr("servosight.tracking.acquisition.find_light", lambda *known, **more: None)
    monkeypatch.setattr("servosight.tracking.video.open_film", opened)
    monkeypatch.setattr("servosight.tracking.track.track_film", track_film)
    return kept


def opened(video: Path, options: TrackOptions) -> SimpleNamespace:
    """A film of which nothing but the path is known."""
    return SimpleNamespace(path=video)


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
        assert main(["track", str(rec), "--alone"]) == 0
        assert tracker["exposure_s"] is None
        assert load_recording(rec).exposure_s == pytest.approx(0.003)
    with (rec / "recording.toml").open("a") as file:
        file.write("[camera]\nexposure_s = 0.004\n")
    assert main(["track", str(rec), "--alone"]) == 0
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


def test_pictures_that_a_video_lacks_are_said_by_all_who_use_its_angle(
    tmp_path: Path, tracker: dict[str, Any], asked: dict[str, Any]
) -> None:
    """Until it is tracked anew with all of them."""
    rec = filmed(tmp_path / "rec", 'import_notes = ["command.csv: as before"]\n')
    tracker["lost"] = ("the angle ends early",)
    for _ in range(2):
        assert main(["diagnose", str(rec)]) == 0
        notes = asked["recordings"][0].notes
        assert notes == ("command.csv: as before", "video.mkv: the angle ends early")
    assert main(["track", str(rec), "--alone", "--force"]) == 0
    assert load_recording(rec).notes == ("command.csv: as before",)


def test_track_a_file_that_is_no_video(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    complaint(capsys, ["track", str(tmp_path / "no.mkv")], "no.mkv", "no such file")
    (tmp_path / "a.mkv").write_bytes(b"junk" * 100)
    complaint(capsys, ["track", str(tmp_path / "a.mkv")], "a.mkv", "expected")
    assert not (tmp_path / "angle.csv").exists()


def test_a_recording_without_a_video_is_not_offered_for_replacement(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    complaint(capsys, ["track", str(recording(tmp_path / "rec"))], "holds no video", "expected")


def test_a_markers_number_without_a_marker_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["track", str(tmp_path / "a.mkv"), "--id", "3"]
    complaint(capsys, words, "--id has no effect here", "expected --marker")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["track", "a.mkv", "--marker", "aruco", "--id", "3.5"], "expected a whole number"),
        (["calibrate", "--columns", "x", "--rows", "6"], "expected a whole number"),
        (["calibrate", "--columns", "9", "--rows", "6", "--square-mm", "inf"], "expected a number"),
    ],
)
def test_a_number_that_is_none_is_refused_in_a_sentence(
    words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    complaint(capsys, words, expected)


@pytest.mark.parametrize("second", [["--second"], ["--second-pivot", "3,4"]])
def test_a_second_part_beside_a_marker_is_refused(
    second: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["track", str(tmp_path / "a.mkv"), "--marker", "aruco", *second]
    complaint(capsys, words, "follows one marker", "expected one of the two")


def test_the_method_marker_follows_the_number_that_is_given(
    tmp_path: Path, tracker: dict[str, Any]
) -> None:
    video = tmp_path / "a.mkv"
    video.touch()
    assert main(["track", str(video), "--method", "marker", "--id", "3"]) == 0
    assert (tracker["method"], tracker["marker_family"], tracker["marker_id"]) == (
        "marker",
        "aruco",
        3,
    )


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


def test_the_help_of_track_names_every_method(capsys: pytest.CaptureFixture[str]) -> None:
    from servosight.tracking.methods import METHODS

    assert main(["track", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    for name in METHODS:
        assert f"{name}: " in told
    assert "(default: refine)" in told
