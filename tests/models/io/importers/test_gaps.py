"""Rows without an angle or a command: left out with one sentence, in each format."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.refusal import refused

from servosight.models.io.importers import Request, import_recording

ROWS = [(0.01 * i, float(i % 7), float(i % 5)) for i in range(100)]
HEADER = "time_s,command_deg,angle_deg"


@pytest.mark.parametrize("cell", ["", "nan", "NULL", "n/a", "-"])
def test_rows_without_an_angle_are_left_out(tmp_path: Path, cell: str) -> None:
    path = tmp_path / "a.csv"
    lines = [f"{t!r},{u!r},{y!r}" for t, u, y in ROWS]
    for row in (40, 41, 70):
        lines[row] = f"{ROWS[row][0]!r},{ROWS[row][1]!r},{cell}"
    path.write_text("\n".join([HEADER, *lines]))
    recording = import_recording(path, Request())
    assert recording.time_s.size == 97
    assert recording.command_deg.size == 100
    (note,) = recording.notes
    assert "3 of 100 rows have no number in angle_deg, and were left out" in note
    assert note.endswith("the first is row 42")
    path.write_text(path.read_text().replace(lines[60], "0.6,1.0,inf"))
    refused(path, Request(), "row 62", "angle_deg", "inf", "finite")


def test_a_command_that_is_logged_where_it_changes_holds_in_between(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    lines = [
        f"{t!r},{u!r},{y!r}" if i % 4 == 0 else f"{t!r},,{y!r}" for i, (t, u, y) in enumerate(ROWS)
    ]
    path.write_text("\n".join([HEADER, *lines]))
    recording = import_recording(path, Request())
    assert recording.time_s.size == 100
    assert recording.command_time_s.tolist() == [t for t, _, _ in ROWS[::4]]
    assert recording.command_deg.tolist() == [u for _, u, _ in ROWS[::4]]
    assert (
        "75 of 100 rows have no number in command_deg, where the command before"
        in (recording.notes[0])
    )


def test_nothing_but_gaps_and_nothing_but_a_header(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join([HEADER, *(f"{t!r},{u!r}," for t, u, _ in ROWS)]))
    refused(path, Request(), "angle_deg", "0 samples")
    path.write_text(HEADER + "\n")
    refused(path, Request(), "angle_deg", "0 samples")


def test_a_null_in_json_is_a_gap(tmp_path: Path) -> None:
    t, u, y = np.array(ROWS).T.tolist()
    path = tmp_path / "a.json"
    y[3] = None
    path.write_text(json.dumps({"time_s": t, "command_deg": u, "angle_deg": y}))
    assert (
        "1 of 100 values have no number in angle_deg" in import_recording(path, Request()).notes[0]
    )
