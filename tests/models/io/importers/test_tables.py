"""Tables that people have: separators, comments, dates, and rows that mean nothing."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.refusal import refused
from support.written_logs import is_the_sine, sine_rows

from servosight.app.main import main
from servosight.models.core import InputError
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording, parse_map


def test_samples_of_one_stamp_become_their_mean(tmp_path: Path) -> None:
    """Three samples in each tick of the clock; the command is the last of them."""
    rows = [f"{0.01 * (i // 3):.2f},{i},{2 * i}" for i in range(180)]
    (tmp_path / "a.csv").write_text("\n".join(["time_s,command_deg,angle_deg", *rows]))
    recording = import_recording(tmp_path / "a.csv", Request())
    assert recording.angle_deg.tolist() == [6.0 * i + 2.0 for i in range(60)]
    assert recording.command_deg.tolist() == [3.0 * i + 2.0 for i in range(60)]
    assert "180 of 180 samples share their time stamp" in recording.notes[0]
    with pytest.raises(InputError, match=r"stands still.*servosight import"):
        load_recording(tmp_path / "a.csv")


def test_an_angle_that_passes_the_end_of_its_scale_is_made_continuous(tmp_path: Path) -> None:
    """Also where the command is on the same scale, or on one of more turns."""
    t = 0.01 * np.arange(200)
    command = 170.0 + 60.0 * np.sin(9.0 * t)
    angle = 170.0 + 60.0 * np.sin(9.0 * t - 0.2)

    def wrapped(values: Any) -> Any:
        return (values + 180.0) % 360.0 - 180.0

    for sent in (command, wrapped(command), command + 720.0):
        rows = zip(t.tolist(), sent.tolist(), wrapped(angle).tolist(), strict=True)
        text = "\n".join(f"{x:.2f},{u},{y}" for x, u, y in rows)
        (tmp_path / "a.csv").write_text(f"time_s,command_deg,angle_deg\n{text}")
        recording = import_recording(tmp_path / "a.csv", Request())
        turns = 360.0 * np.round((recording.angle_deg[0] - angle[0]) / 360.0)
        np.testing.assert_allclose(recording.angle_deg, angle + turns, atol=1e-9)
        np.testing.assert_allclose(recording.command_deg, command + turns, atol=1e-9)
        (note,) = recording.notes
        assert "passes the end of its scale 6 times" in note


def test_a_command_that_jumps_far_stays(tmp_path: Path) -> None:
    rows = [f"{0.01 * i:.2f},{350 * (i > 20)},{min(max(7 * (i - 20), 0), 350)}" for i in range(99)]
    (tmp_path / "a.csv").write_text("\n".join(["time_s,command_deg,angle_deg", *rows]))
    recording = import_recording(tmp_path / "a.csv", Request())
    assert recording.command_deg.max() == 350.0
    assert recording.notes == ()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [([80], "1 read error or old value"), ([80, 190], "2 read errors and old values")],
)
def test_the_range_that_import_reports_has_no_read_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: list[int], said: str
) -> None:
    t = 0.01 * np.arange(300)
    angle = 20.0 * np.sin(5.0 * t)
    angle[wrong] += 180.0
    rows = zip(t.tolist(), angle.tolist(), strict=True)
    text = "\n".join(f"{x:.2f},{20 * math.sin(5 * x + 0.2)},{y}" for x, y in rows)
    (tmp_path / "a.csv").write_text(f"time_s,command_deg,angle_deg\n{text}")
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "rec")]) == 0
    assert f"moved 40 deg without {said}" in capsys.readouterr().out


@pytest.mark.parametrize("stamp", ["0.01", "90.0"], ids=["too early", "too late"])
def test_a_few_bad_stamps_cost_their_rows(tmp_path: Path, stamp: str) -> None:
    """One row in a hundred, with one sentence; two are refused, as a wrong clock is."""
    rows = [f"{0.01 * i:.2f},{i % 7},{i % 5}" for i in range(150)]
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(
            ["time_s,command_deg,angle_deg", *rows[:70], f"{stamp},70,70", *rows[70:]],
        )
    )
    recording = import_recording(path, Request())
    assert recording.time_s.tolist() == [float(f"{0.01 * i:.2f}") for i in range(150)]
    assert recording.angle_deg.max() == 4.0
    (note,) = recording.notes
    assert note.endswith(
        "1 of 151 rows, where time_s jumps away from the clock, was left out, the first is row 72"
    )
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:100], lines[71], *lines[100:]]))
    if stamp == "0.01":
        refused(path, Request(), "row 72", "runs back")
    with pytest.raises(InputError, match=r"runs back.*servosight import"):
        load_recording(path)


@pytest.mark.parametrize(("on", "off"), [("1", "0"), ("True", "False")])
def test_a_table_without_torque_at_the_end_is_cut(tmp_path: Path, on: str, off: str) -> None:
    rows = [f"{0.01 * i:.2f},{i % 7},{i % 5},{on if i < 70 else off}" for i in range(100)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["time_s,command_deg,angle_deg,torque_enable", *rows]))
    recording = import_recording(path, Request())
    assert recording.time_s.size == 70
    assert "false in 30 of 100 rows" in recording.notes[0]
    save_recording(recording, tmp_path / "rec")
    assert load_recording(tmp_path / "rec").notes == recording.notes


@pytest.mark.parametrize("mark", [" ", "   ", "\t", ";"])
def test_comments_and_separators(tmp_path: Path, mark: str) -> None:
    """Comments within the table, and a header that is the last of those above it, as of numpy."""
    path = tmp_path / "a.txt"
    rows = sine_rows(mark)
    header = mark.join(["time_s", "command_deg", "angle_deg"])
    path.write_text("\n".join(["# run 7", header, *rows[:9], "# pause", *rows[9:]]))
    for one in (import_recording(path, Request()), load_recording(path)):
        is_the_sine(one)
        (note,) = one.notes
        assert "2 lines that begin with # are skipped, the first is row 1" in note
    path.write_text("\n".join(["# run 7", f"# {header}", *rows]))
    recording = import_recording(path, Request())
    is_the_sine(recording)
    assert "1 line that begins with # is skipped, the first is row 1" in recording.notes[0]


def test_what_numpy_writes_is_read(tmp_path: Path) -> None:
    t = 0.01 * np.arange(99)
    table = np.column_stack([t, np.sin(9 * t), np.sin(9 * t - 0.2)])
    np.savetxt(tmp_path / "a.txt", table, header="time_s command_deg angle_deg")
    recording = load_recording(tmp_path / "a.txt")
    is_the_sine(recording)
    assert recording.notes == ()


@pytest.mark.parametrize("name", ["time", "when"])
def test_dates_are_a_time(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    rows = sine_rows(stamp="2026-03-01T12:00:")
    path.write_text("\n".join([f"{name},command_deg,angle_deg", *rows]))
    request = Request(parse_map([] if name == "time" else ["time=when"]))
    recording = import_recording(path, request)
    is_the_sine(recording)
    assert recording.time_s[0] == 1772366400.0
    assert f"column {name} holds dates, read as seconds since 1970" in recording.notes[0]
    path.write_text(path.read_text().replace("2026-03-01T12:00:00.30", "later"))
    refused(path, request, "row 32", name, "'later'", "date")


def test_counts_that_pass_the_end_of_their_scale_are_made_continuous(tmp_path: Path) -> None:
    t = 0.01 * np.arange(200)
    command, angle = (np.round(900 * np.sin(9.0 * t - lag)) for lag in (0.0, 0.2))
    rows = zip(t.tolist(), (command % 4096).tolist(), (angle % 4096).tolist(), strict=True)
    text = "\n".join(f"{x:.2f},{u},{y}" for x, u, y in rows)
    (tmp_path / "a.csv").write_text(f"time_s,command (ticks),angle (ticks)\n{text}")
    words = ["command=command", "angle=angle"]
    recording = import_recording(
        tmp_path / "a.csv", Request(parse_map(words), unit_scale=360.0 / 4096.0)
    )
    np.testing.assert_allclose(recording.angle_deg, 360.0 + angle * 360.0 / 4096.0)
    np.testing.assert_allclose(recording.command_deg, 360.0 + command * 360.0 / 4096.0)


def test_one_scale_does_not_hold_for_two_units(tmp_path: Path) -> None:
    rows = [f"{0.01 * i:.2f},{i % 7},{i % 5}" for i in range(99)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["time_s,goal (%),pos (ticks)", *rows]))
    request = Request(parse_map(["command=goal", "angle=pos"]), unit_scale=0.1)
    refused(path, request, "% and ticks", "one unit", "--unit-scale")
