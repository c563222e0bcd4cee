"""JSON of records and of columns becomes a recording, or is refused with one sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.foreign_logs import COUNT, GOAL, MAP, POSITION, TIMES, is_sound, nested
from support.refusal import refused

from servosight.models.io.importers import Request, import_recording, parse_map
from servosight.sources import read


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(nested()),
        json.dumps({"servo": "x", "samples": nested()}),
        "\n".join(map(json.dumps, nested())),
    ],
    ids=["list", "object", "lines"],
)
def test_json_of_records(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.log"
    path.write_text(text)
    recording = import_recording(path, MAP)
    is_sound(recording)
    assert recording.details["source"]["angle_column"] == "pos[1]"


def test_json_of_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"time_s": TIMES, "command (rad)": GOAL, "angle_rad": POSITION}))
    is_sound(import_recording(path, Request()))
    is_sound(read(path))


@pytest.mark.parametrize(
    ("records", "words"),
    [
        ([*nested()[:7], {**nested()[7], "t": "x"}, *nested()[8:]], ("record 7", "t is 'x'")),
        ([*nested()[:7], "x", *nested()[8:]], ("record 7", "'x'", "expected an object")),
        ([], ("no records",)),
        ([1, 2], ("no records",)),
    ],
)
def test_json_with_a_fault(tmp_path: Path, records: Any, words: tuple[str, ...]) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(records))
    refused(path, MAP, *words)


@pytest.mark.parametrize(
    "content",
    [
        {"meta": {"names": ["a", "b"]}, "run": {"log": nested()}},
        [one for n in nested() for one in ({"t": n["t"], "arm": n["arm"]}, {**n, "arm": None})],
        [{**n, "t": str(n["t"])} for n in nested()],
        [{**n, "t": f"2026-03-01T12:00:{n['t'] / 1e3:09.6f}Z"} for n in nested()],
    ],
    ids=["nested", "a stream in each record", "text", "dates"],
)
def test_json_of_records_as_programs_write_them(tmp_path: Path, content: Any) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(content))
    recording = import_recording(path, MAP)
    np.testing.assert_allclose(recording.time_s - recording.time_s[0], TIMES, atol=1e-6)
    np.testing.assert_allclose(recording.angle_deg, np.degrees(POSITION))
    np.testing.assert_allclose(recording.command_deg, np.degrees(GOAL))


def test_json_of_columns_in_objects_and_of_rows_in_lists(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    columns = {"time_s": TIMES, "command_rad": GOAL, "angle_rad": POSITION}
    path.write_text(json.dumps({k: dict(enumerate(v)) for k, v in columns.items()}))
    is_sound(import_recording(path, Request()))
    path.write_text(json.dumps({"servo": columns, "names": ["a"]}))
    words = [f"{name.partition('_')[0]}=servo.{name}" for name in columns]
    is_sound(import_recording(path, Request(parse_map(words))))
    path.write_text(json.dumps(list(zip(*columns.values(), strict=True))))
    words = ["time=[0]:s", "command=[1]:rad", "angle=[2]:rad"]
    is_sound(import_recording(path, Request(parse_map(words))))


def test_a_line_that_breaks_off_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("\n".join(map(json.dumps, nested()))[:-4])
    refused(path, MAP, f"row {COUNT}", "is no JSON")


def test_json_columns_with_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    table = {"time_s": TIMES, "command_rad": GOAL, "angle_rad": [*POSITION[:-1], "x"]}
    path.write_text(json.dumps(table))
    refused(path, Request(), "value 199", "angle_rad", "'x'")
    path.write_text(json.dumps(table | {"angle_rad": POSITION[:-1]}))
    refused(path, Request(), "199 values", "200")
    path.write_text('[{"t": 1}, {')
    refused(path, Request(), "is no JSON")
    path.write_text("[" * 100_000)
    refused(path, Request(), "JSON")


@pytest.mark.parametrize("text", [True, False], ids=["records", "columns"])
def test_json_without_torque_at_the_end(tmp_path: Path, text: bool) -> None:
    on = [n < 150 for n in range(COUNT)]
    content: Any = {"time_s": TIMES, "command_rad": GOAL, "angle_rad": POSITION, "TorqueEnable": on}
    if text:
        rows = zip(*content.values(), strict=True)
        content = [dict(zip(content, row, strict=True)) for row in rows]
    (tmp_path / "a.json").write_text(json.dumps(content))
    recording = import_recording(tmp_path / "a.json", Request())
    assert recording.time_s.size == 150
    assert "TorqueEnable is false in 50 of 200" in recording.notes[0]
