"""Logs of other programs become recordings, or are refused with one sentence."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st
from support.refusal import refused

from servosight.app.main import main
from servosight.models.core import InputError, Recording
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Column, Request, import_recording, parse_map


def bam_log(count: int = 100, **changes: Any) -> dict[str, Any]:
    entries = [
        {
            "timestamp": 0.005 * i,
            "goal_position": 0.5 * math.sin(0.1 * i),
            "position": 0.4 * math.sin(0.1 * i - 0.1),
            "load": 3,
            "input_volts": 7.4 - 0.001 * i,
            "temp": 28 if i else None,
            "torque_enable": True,
        }
        for i in range(count)
    ]
    return {"mass": 0.49, "length": 0.1, "kp": 100, "vin": 7.4, "motor": "xl330"} | {
        "entries": entries,
        **changes,
    }


def saved(path: Path, log: Any) -> Path:
    path.write_text(json.dumps(log))
    return path


def test_bam_in_degrees_with_provenance(tmp_path: Path) -> None:
    imported = import_recording(saved(tmp_path / "a.json", bam_log()), Request())
    recording = imported
    assert imported.notes == ()
    assert recording.relative_gain == 0.25  # 100 over the firmware's 400
    assert recording.side == "sensor"
    assert recording.command_deg[7] == pytest.approx(math.degrees(0.5 * math.sin(0.7)))
    save_recording(recording, tmp_path / "rec")
    read = load_recording(tmp_path / "rec")
    np.testing.assert_array_equal(read.angle_deg, recording.angle_deg)
    assert read.relative_gain == 0.25
    assert read.signals is not None
    assert list(read.signals.values) == ["supply_V", "load"]  # temp is not in every entry
    assert read.signals.values["supply_V"][10] == 7.4 - 0.001 * 10
    assert read.side == "sensor"
    interval_s = float(np.median(np.diff(recording.time_s)))
    assert read.offset_sigma_s == pytest.approx(interval_s / 12**0.5, rel=0.01)
    source = read.details["source"]
    assert source["name"] == "a.json"
    assert {key: source[key] for key in ("mass", "length", "kp", "vin", "motor")} == {
        "mass": 0.49,
        "length": 0.1,
        "kp": 100,
        "vin": 7.4,
        "motor": "xl330",
    }


def test_bam_without_torque_is_cut(tmp_path: Path) -> None:
    log = bam_log()
    for entry in log["entries"][80:]:
        entry["torque_enable"] = False
    imported = import_recording(saved(tmp_path / "a.json", log), Request())
    assert imported.time_s.size == 80
    assert "20 of 100" in imported.notes[0]
    assert imported.details["source"]["kept_entries"] == [0, 79]


def broken(index: int, **changes: Any) -> dict[str, Any]:
    log = bam_log()
    log["entries"][index].update(changes)
    return log


@pytest.mark.parametrize(
    ("log", "words"),
    [
        ([], ("no records", "no columns")),
        ({}, ("no records", "no columns")),
        (bam_log(entries=[]), ("entries", "empty")),
        (bam_log(entries=[3] * 60), ("entry 0", "object")),
        (bam_log(40), ("40 samples", "at least 50")),
        (broken(7, position="x"), ("entry 7", "position", "'x'", "number")),
        (broken(7, position=True), ("entry 7", "position", "number")),
        (broken(7, position=None), ("entry 7", "position", "number")),
        (broken(7, position=math.nan), ("entry 7", "position", "finite")),
        (broken(7, position=10**400), ("entries", "1329 bits", "at most 64")),
        (broken(7, torque_enable="on"), ("entry 7", "torque_enable", "true or false")),
        (bam_log(entries=bam_log()["entries"][::-1]), ("entry 1", "timestamp", "runs back")),
        (
            bam_log(entries=[{**e, "torque_enable": False} for e in bam_log()["entries"]]),
            ("torque_enable", "switched on"),
        ),
    ],
)
def test_bad_bam(tmp_path: Path, log: Any, words: tuple[str, ...]) -> None:
    refused(saved(tmp_path / "a.json", log), Request(), *words)


def test_bam_that_is_no_json(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text('{"entries": [')
    refused(path, Request(), "JSON", "whole")
    refused(saved(path, bam_log()), Request(unit="deg"), "--unit", "leave")
    refused(tmp_path / "b.json", Request(), "no such file")


def csv_log(path: Path, header: str = "t;goal;pos") -> Path:
    rows = [f"{8 * i};{math.sin(0.2 * i)};{math.sin(0.2 * i - 0.3)}" for i in range(60)]
    path.write_text("\n".join([header, *rows]))
    return path


def test_csv_with_other_headers_and_units(tmp_path: Path) -> None:
    columns = parse_map(["time=t:ms", "command=goal:rad", "angle=pos:rad"])
    recording = import_recording(csv_log(tmp_path / "a.csv"), Request(columns))
    assert recording.time_s[1] == 0.008
    assert recording.angle_deg[5] == pytest.approx(math.degrees(math.sin(0.7)))
    by_unit = Request(parse_map(["time=t:ms", "command=goal", "angle=pos"]), unit="rad")
    again = import_recording(csv_log(tmp_path / "a.csv"), by_unit)
    np.testing.assert_array_equal(recording.angle_deg, again.angle_deg)


def test_csv_whose_names_tell_their_units(tmp_path: Path) -> None:
    path = csv_log(tmp_path / "a.csv", "time_ms;goal_rad;angle_deg")
    recording = import_recording(path, Request(parse_map(["command=goal_rad"])))
    assert recording.time_s[1] == 0.008
    assert recording.command_deg[5] == pytest.approx(math.degrees(math.sin(1.0)))
    assert recording.angle_deg[5] == pytest.approx(math.sin(0.7))


def test_csv_with_colons_pulses_and_metres(tmp_path: Path) -> None:
    path = csv_log(tmp_path / "a.csv", "t;cmd:us;x")
    columns = parse_map(["time=t:ms", "command=cmd:us:us", "angle=x:m"])
    request = Request(columns, unit_scale=10.0, deg_per_us=2.0, neutral_us=1.0)
    recording = import_recording(path, request)
    assert recording.command_deg[5] == pytest.approx(2.0 * (math.sin(1.0) - 1.0))
    assert recording.angle_deg[5] == pytest.approx(10.0 * math.sin(0.7))
    save_recording(recording, tmp_path / "rec")
    read = load_recording(tmp_path / "rec")
    assert read.details["unit"] == "m"
    np.testing.assert_allclose(read.angle_deg, recording.angle_deg, rtol=1e-15)


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (Request(), ("row 1", "time", "--map time=COLUMN", "t, goal, pos")),
        (Request({"time": Column("T")}), ("row 1", "no column T", "t, goal, pos", "--map")),
        (
            Request(parse_map(["time=t:h", "command=goal:deg", "angle=pos:deg"])),
            ("column t", "'h'", "s, ms, us"),
        ),
        (
            Request(parse_map(["time=t:ms", "command=goal:deg", "angle=pos:m"])),
            ("column pos", "'m'", "--unit-scale"),
        ),
        (
            Request(parse_map(["time=t:ms", "command=goal:us", "angle=pos:deg"])),
            ("column goal", "--deg-per-us"),
        ),
        (
            Request(parse_map(["time=t:s", "command=goal:deg", "angle=pos:deg"])),
            ("column t", "8 s", "milli"),
        ),
    ],
)
def test_bad_maps(tmp_path: Path, request_: Request, words: tuple[str, ...]) -> None:
    refused(csv_log(tmp_path / "a.csv"), request_, *words)


@pytest.mark.parametrize("word", ["time", "speed=v", "time=", "time=:ms"])
def test_maps_that_say_nothing(word: str) -> None:
    with pytest.raises(InputError, match=r"columns: .*expected"):
        parse_map([word])


def test_a_quantity_mapped_twice() -> None:
    with pytest.raises(InputError, match="twice"):
        parse_map(["time=a", "time=b"])


def two_tables(place: Path) -> tuple[Path, Path]:
    """What a controller measured and, at a lower rate, what it wanted."""
    measured, wanted = place / "measured.csv", place / "desired.csv"
    t = 0.01 * np.arange(100)
    rows = [f"{x},{math.sin(9 * x - 0.1)},{0.3 * x}" for x in t.tolist()]
    measured.write_text("\n".join(["time,position,torque", *rows]))
    rows = [f"{x},{math.sin(9 * x)}" for x in t[::2].tolist()]
    wanted.write_text("\n".join(["time,position", *rows]))
    return measured, wanted


def test_a_command_in_a_table_of_its_own(tmp_path: Path) -> None:
    measured, wanted = two_tables(tmp_path)
    words = ["time=time", "angle=position:rad", "command=position:rad", "torque=torque:Nm"]
    recording = import_recording(measured, Request(parse_map(words), command=wanted))
    assert (recording.time_s.size, recording.command_time_s.size) == (100, 50)
    assert recording.command_deg[3] == pytest.approx(math.degrees(math.sin(0.54)))
    assert recording.angle_deg[3] == pytest.approx(math.degrees(math.sin(0.17)))
    assert recording.signals is not None
    assert recording.details["source"]["command_name"] == "desired.csv"
    assert recording.details["source"]["command_column"] == "position"


def test_bad_tables_of_a_command(tmp_path: Path) -> None:
    measured, wanted = two_tables(tmp_path)
    columns = parse_map(["time=time", "angle=position:rad", "command=position:rad"])
    with pytest.raises(InputError, match=r"desired\.csv, row 1: no column goal, expected"):
        import_recording(measured, Request({**columns, "command": Column("goal")}, command=wanted))
    spoilt = tmp_path / "spoilt_measured.csv"
    spoilt.write_text(wanted.read_text().replace("0.08,", "0.01,").replace("0.5,", "0.0,"))
    with pytest.raises(InputError, match=r"spoilt_measured\.csv, row 6.*runs back"):
        import_recording(measured, Request(columns, command=spoilt))
    with pytest.raises(InputError, match=r"gone\.csv: no such file, expected"):
        import_recording(measured, Request(columns, command=tmp_path / "gone.csv"))
    log = saved(tmp_path / "log.json", bam_log())
    with pytest.raises(InputError, match=r"log\.json: is no table of text, expected"):
        import_recording(measured, Request(columns, command=log))
    with pytest.raises(InputError, match=r"log\.json: is no table of text, expected"):
        import_recording(log, Request(columns, command=wanted))


def mat_file(path: Path, **changes: Any) -> Path:
    t = 0.001 * np.arange(200)[:, None]
    sound = {"t": t, "qg": np.sin(9 * t), "qm": np.sin(9 * t - 0.1), "kp": 160.18}
    scipy.io.savemat(path, sound | changes)
    return path


def test_emps(tmp_path: Path) -> None:
    recording = import_recording(mat_file(tmp_path / "a.mat"), Request())
    assert recording.angle_deg[10] == pytest.approx(100.0 * math.sin(0.09 - 0.1))
    assert recording.details["unit_scale"] == 100.0
    assert recording.details["source"]["kp"] == 160.18


def test_other_mat_files_by_map(tmp_path: Path) -> None:
    path = mat_file(tmp_path / "a.mat", y=np.arange(200.0))
    recording = import_recording(path, Request(parse_map(["angle=y:deg"])))
    assert recording.angle_deg[3] == 3.0
    refused(path, Request(parse_map(["angle=z:deg"])), "no column z", "qg", "--map")


def test_fields_of_structs_in_mat_files(tmp_path: Path) -> None:
    """By MATLAB's own names, also of a struct in a struct and of an array of structs."""
    t = 0.01 * np.arange(200)
    signals = np.array([(np.sin(9 * t),), (np.cos(9 * t),)], dtype=[("values", object)])
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"out": {"time": t, "y": np.sin(9 * t), "log": {"signals": signals}}})
    words = ["time=out.time", "command=out.log.signals(2).values:rad", "angle=out.y:rad"]
    recording = import_recording(path, Request(parse_map(words)))
    assert recording.command_deg[0] == pytest.approx(math.degrees(1.0))
    names = "out.time, out.y, out.log.signals(1).values, out.log.signals(2).values"
    refused(path, Request(), "--map time=COLUMN", names)


def test_bad_mat_files(tmp_path: Path) -> None:
    refused(mat_file(tmp_path / "a.mat", qm=np.ones(7)), Request(), "qm", "7 values", "200")
    refused(mat_file(tmp_path / "a.mat", qm="text"), Request(), "angle", "--map angle=COLUMN")
    bad = np.sin(np.arange(200.0))
    bad[4] = np.nan
    refused(mat_file(tmp_path / "a.mat", qm=bad), Request(), "sample 5", "qm", "finite")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file" + bytes(200))
    refused(tmp_path / "b.mat", Request(), "MATLAB", "-v7")


@settings(max_examples=150)
@given(
    ending=st.sampled_from([".json", ".mat", ".csv"]),
    data=st.binary(max_size=200)
    | st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(max_size=4),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(st.sampled_from(["entries", "position", "timestamp"]), inner)
        ),
        max_leaves=6,
    ).map(lambda value: json.dumps(value).encode()),
)
def test_any_bytes_are_refused_with_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, ending: str, data: bytes
) -> None:
    path = tmp_path_factory.mktemp("any") / f"log{ending}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="log"):
        import_recording(path, Request())


# --- real logs ------------------------------------------------------------------------------


@pytest.mark.parametrize("gain", [100, 200, 400, 800])
def test_xl330_logs(real_data: Path, gain: int) -> None:
    place = real_data / "xl330"
    for name in ("sin_sin", "up_and_down"):
        imported = import_recording(place / f"{name}_kp{gain}.json", Request())
        assert imported.notes == ()
        assert imported.duration_s == pytest.approx(6.0, abs=0.02)
        assert imported.details["source"]["kp"] == gain
    dropped = import_recording(place / f"lift_and_drop_kp{gain}.json", Request())
    assert dropped.duration_s == pytest.approx(2.0, abs=0.02)
    assert "torque_enable" in dropped.notes[0]


def test_ak80_in_two_tables(real_data: Path) -> None:
    place = real_data / "ak80"
    columns = parse_map(["time=time", "angle=position:rad", "command=position:rad"])
    request = Request(columns, command=place / "swingup_desired.csv")
    recording = import_recording(place / "swingup_measured.csv", request)
    assert recording.time_s.size == 1170
    assert recording.moved_range_deg == pytest.approx(287.7, abs=0.1)


def test_emps_benchmark(real_data: Path) -> None:
    recording = import_recording(real_data / "emps" / "DATA_EMPS.mat", Request())
    assert recording.time_s.size == 24841
    assert recording.moved_range_deg == pytest.approx(24.64, abs=0.01)


# --- units of headers, stamps, torque -------------------------------------------------------


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


def test_columns_with_the_quantities_names_need_no_map(tmp_path: Path) -> None:
    path = csv_log(tmp_path / "a.csv", "Time (ms);Command (deg);Angle (deg)")
    assert import_recording(path, Request()).time_s[1] == 0.008


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("t_ms;goal_rad;pos", ("column pos for the angle has no unit", "angle=pos:rad", "--unit")),
        ("t_ms;goal_rad;pos (counts)", ("column pos (counts)", "'counts'", "--unit-scale")),
        ("t (h);goal_rad;pos_rad", ("column t (h)", "'h'", "s, ms, us, ns")),
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


def test_the_range_that_import_reports_has_no_read_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = 0.01 * np.arange(300)
    angle = 20.0 * np.sin(5.0 * t)
    angle[[80, 190]] += 180.0
    rows = zip(t.tolist(), angle.tolist(), strict=True)
    text = "\n".join(f"{x:.2f},{20 * math.sin(5 * x + 0.2)},{y}" for x, y in rows)
    (tmp_path / "a.csv").write_text(f"time_s,command_deg,angle_deg\n{text}")
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "rec")]) == 0
    assert "moved 40 deg without 2 read errors and old values" in capsys.readouterr().out


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


@pytest.mark.parametrize("name", ["Torque Enable", "torque_enabled", "TorqueEnable"])
def test_other_spellings_of_torque_enable(tmp_path: Path, name: str) -> None:
    """In a table, also as a recording by itself, and in a MATLAB file."""
    rows = [f"{0.01 * i:.2f},{i % 7},{i % 5},{int(i < 70)}" for i in range(100)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([f"time_s,command_deg,angle_deg,{name}", *rows]))
    on = np.arange(200) < 120
    mat = mat_file(tmp_path / "a.mat", **{name.replace(" ", ""): on})
    for one, size in (
        (import_recording(path, Request()), 70),
        (load_recording(path), 70),
        (import_recording(mat, Request()), 120),
    ):
        assert one.time_s.size == size
        assert f"{name.replace(' ', '')} is false" in one.notes[0].replace(" E", "E")


def test_a_flag_of_another_size_is_refused(tmp_path: Path) -> None:
    mat = mat_file(tmp_path / "a.mat", torque_enable=np.ones(7))
    refused(mat, Request(), "torque_enable 7", "200 values")


def test_the_map_of_the_command_is_that_of_read(tmp_path: Path) -> None:
    import servosight as ss

    path = csv_log(tmp_path / "a.csv")
    words = ["--map", "time=t:ms", "--map", "command=goal:rad", "--map", "angle=pos:rad"]
    assert main(["import", str(path), *words, "-o", str(tmp_path / "rec")]) == 0
    read = ss.read(path, columns={"time": "t:ms", "command": "goal:rad", "angle": "pos:rad"})
    imported = ss.read(tmp_path / "rec")
    np.testing.assert_array_equal(read.angle_deg, imported.angle_deg)
    np.testing.assert_array_equal(read.command_deg, imported.command_deg)
    np.testing.assert_array_equal(read.time_s, imported.time_s)


# --- tables that people have --------------------------------------------------------------------


def sine_rows(mark: str = ",", stamp: str = "") -> list[str]:
    """Rows of time, command and angle, 10 ms apart; ``stamp`` stands before each time."""
    t = [0.01 * i for i in range(99)]
    return [f"{stamp}{x:05.2f}{mark}{math.sin(9 * x)}{mark}{math.sin(9 * x - 0.2)}" for x in t]


def is_the_sine(recording: Recording, unit: float = 1.0) -> None:
    np.testing.assert_allclose(np.diff(recording.time_s), 0.01, atol=1e-6)
    angle = [unit * math.sin(0.09 * i - 0.2) for i in range(99)]
    np.testing.assert_allclose(recording.angle_deg, angle, atol=1e-9)


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
