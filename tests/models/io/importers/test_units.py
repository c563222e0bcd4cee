"""Units that a table's headers name, and what is said where none does."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path

import pytest
from support.refusal import refused
from support.written_logs import csv_log, is_the_sine, sine_rows

from servosight.app.main import main
from servosight.models.core import InputError
from servosight.models.io import load_recording
from servosight.models.io.importers import Column, Request, import_recording, parse_map


@pytest.mark.parametrize(
    "header",
    ["t [ms];goal (rad);pos (rad)", "t/ms;goal_rad;pos/rad", "t (msec);goal [Radians];pos [rad]"],
)
def test_units_in_headers_are_used(tmp_path: Path, header: str) -> None:
    """The map names the bare column; what the map says goes before the header."""
    path = csv_log(tmp_path / "a.csv", header)
    columns = parse_map(["time=t", "command=goal", "angle=pos"])
    recording = import_recording(path, Request(columns, unit="deg"))
    assert recording.time_s[1] == 0.008
    assert recording.angle_deg[5] == pytest.approx(math.degrees(math.sin(0.7)))
    assert recording.command_deg[5] == pytest.approx(math.degrees(math.sin(1.0)))
    mapped = import_recording(path, Request(columns | {"angle": Column("pos", "deg")}))
    assert mapped.angle_deg[5] == pytest.approx(math.sin(0.7))


@pytest.mark.parametrize(
    ("header", "unit", "seconds"),
    [("t (min)", "", 60.0), ("time_h", "", 3600.0), ("t [hours]", "", 3600.0), ("t", ":min", 60.0)],
)
def test_minutes_and_hours_are_units_of_time(
    tmp_path: Path, header: str, unit: str, seconds: float
) -> None:
    rows = [f"{0.02 * i / seconds:.12f};{math.sin(0.2 * i)};{i}" for i in range(60)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([f"{header};goal_rad;angle_min", *rows]))
    columns = parse_map([f"time={header}{unit}", "command=goal", "angle=angle_min:deg"])
    recording = import_recording(path, Request(columns))
    assert recording.time_s[7] == pytest.approx(0.14, abs=1e-8)


def test_columns_with_the_quantities_names_need_no_map(tmp_path: Path) -> None:
    path = csv_log(tmp_path / "a.csv", "Time (ms);Command (deg);Angle (deg)")
    assert import_recording(path, Request()).time_s[1] == 0.008


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("t_ms;goal_rad;pos", ("column pos for the angle has no unit", "angle=pos:rad", "--unit")),
        ("t_ms;goal_rad;pos (counts)", ("column pos (counts)", "'counts'", "--unit-scale")),
        ("t (ticks);goal_rad;pos_rad", ("column t (ticks)", "'ticks'", "s, ms, us, ns")),
        ("t;goal_rad;pos_rad", ("column t", "8 s", "milli")),
    ],
)
def test_units_are_asked_for(tmp_path: Path, header: str, words: tuple[str, ...]) -> None:
    request = Request(parse_map(["time=t", "command=goal", "angle=pos"]))
    refused(csv_log(tmp_path / "a.csv", header), request, *words)


def test_many_columns_are_listed_by_whole_names_and_a_count(tmp_path: Path) -> None:
    """Arrays are one entry each; the numbers shown and left out make all."""
    names = [f"{name}[{n}]" for name in ("q", "dq") for n in range(12)]
    names += [f"joint_{n}_measured" for n in range(60)]
    path = tmp_path / "a.json"
    path.write_text(json.dumps([dict.fromkeys(names, 0.0)]))
    with pytest.raises(InputError) as caught:
        import_recording(path, Request(parse_map(["time=x:s"])))
    shown, _, behind = str(caught.value).partition("one of ")[2].partition(", and ")
    entries = shown.split(", ")
    assert entries[:3] == ["q[0..11]", "dq[0..11]", "joint_0_measured"]
    assert set(entries[2:]) <= set(names)
    assert behind.startswith(f"{60 - len(entries[2:])} more; correct columns={{'time': 'x'}}")


def test_degrees_are_assumed_where_nothing_has_a_unit_and_a_note_says_so(tmp_path: Path) -> None:
    request = Request(parse_map(["time=t:ms", "command=goal", "angle=pos"]))
    recording = import_recording(csv_log(tmp_path / "a.csv", "t;goal;pos"), request)
    assert recording.angle_deg[5] == pytest.approx(math.sin(0.7))
    (note,) = recording.notes
    assert "no unit is given for goal and pos, read in degrees" in note


def test_columns_without_units_get_the_command_to_copy(tmp_path: Path) -> None:
    path = tmp_path / "my log.csv"
    path.write_text("\n".join(["time,command,angle", *sine_rows()]))
    with pytest.raises(InputError, match="columns time, command, angle have no unit") as caught:
        import_recording(path, Request())
    words = shlex.split(str(caught.value).partition("`")[2].partition("`")[0])
    assert words[:2] == ["servosight", "import"]
    assert main([*words[1:4], str(tmp_path / "rec"), *words[5:]]) == 0
    is_the_sine(load_recording(tmp_path / "rec"))
    with pytest.raises(InputError, match=r"column time has no unit.*time=time:s --unit rad`"):
        import_recording(path, Request(unit="rad"))


@pytest.mark.parametrize(
    "header", ["time [ms],command (rad),angle (rad)", "Time/ms,Command_rad,Angle [rad]"]
)
def test_units_in_a_header_are_read_alike_with_and_without_import(
    tmp_path: Path, header: str
) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{10 * i},{math.sin(0.09 * i)},{math.sin(0.09 * i - 0.2)}" for i in range(99)]
    path.write_text("\n".join([header, *rows]))
    for one in (import_recording(path, Request()), load_recording(path)):
        is_the_sine(one, math.degrees(1.0))
