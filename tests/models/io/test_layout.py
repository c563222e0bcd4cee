"""Where a table begins in a text file, and in which encoding and numerals it is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.written_logs import is_the_sine, sine_rows

from servosight.models.io import load_recording
from servosight.models.io.importers import Request, import_recording, parse_map

HEADER = "time_s,command_deg,angle_deg"
TEXT = "\n".join([HEADER, *sine_rows()])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(TEXT.replace("_deg", " (°)").encode(encoding))
    is_the_sine(load_recording(path))
    is_the_sine(import_recording(path, Request()))


@pytest.mark.parametrize(
    ("above", "count"),
    [("Log of servo 7\n", "1 line"), ("Device: X\nDate: 2026-01-01, 9:05\n\n% a\n", "3 lines")],
)
def test_lines_above_the_header_are_skipped_with_a_note(
    tmp_path: Path, above: str, count: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(above + TEXT)
    recording = load_recording(path)
    is_the_sine(recording)
    (note,) = recording.notes
    assert f"{count} above the header in row {above.count(chr(10)) + 1} " in note
    assert note.endswith("the first is row 1")


@pytest.mark.parametrize("units", ["s,rad,rad", "(s),[rad],(rad)", '"s","rad","rad"'])
def test_a_row_of_units_below_the_header_is_used(tmp_path: Path, units: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["t,goal,pos", units, *sine_rows()]))
    request = Request(parse_map(["time=t", "command=goal", "angle=pos"]))
    recording = import_recording(path, request)
    is_the_sine(recording, 180.0 / np.pi)
    assert recording.notes == ()


def test_a_file_without_header_is_mapped_by_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(sine_rows()))
    recording = import_recording(
        path, Request(parse_map(["time=1:s", "command=2:deg", "angle=3:deg"]))
    )
    is_the_sine(recording)
    assert "has no header, so its columns are called 1 to 3" in recording.notes[0]


@pytest.mark.parametrize("which", ["rows", "header"])
def test_a_separator_at_the_end_of_rows_or_of_the_header_alone(tmp_path: Path, which: str) -> None:
    header, *rows = TEXT.split("\n")
    lines = [header, *(f"{row}," for row in rows)] if which == "rows" else [f"{header},", *rows]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    is_the_sine(load_recording(tmp_path / "a.csv"))


@pytest.mark.parametrize("mark", [",", "."], ids=["1,234.5", "1.234,5"])
def test_separators_of_thousands_beside_a_decimal_mark(tmp_path: Path, mark: str) -> None:
    rows = []
    for row in sine_rows():
        t, u, y = map(float, row.split(","))
        numbers = [f"{1e6 * t + 1e6:,.1f}", f"{u:.12f}", f"{y:.12f}"]
        swapped = [one.translate({44: 46, 46: 44}) for one in numbers]
        rows.append(";".join(numbers if mark == "," else swapped))
    (tmp_path / "a.csv").write_text("\n".join(["t;command_deg;angle_deg", *rows]))
    recording = import_recording(tmp_path / "a.csv", Request(parse_map(["time=t:us"])))
    np.testing.assert_allclose(np.diff(recording.time_s), 0.01, atol=1e-6)


def test_times_of_day_are_a_time(tmp_path: Path) -> None:
    rows = sine_rows(stamp="23:59:")
    (tmp_path / "a.csv").write_text("\n".join(["time,command_deg,angle_deg", *rows]))
    recording = import_recording(tmp_path / "a.csv", Request())
    is_the_sine(recording)
    assert recording.time_s[0] == 86340.0
    assert "column time holds times of day, read as seconds since midnight" in recording.notes[0]
