"""Columns of tables by a map of the user's: which mean what, and in which unit."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.refusal import refused
from support.written_logs import bam_log, csv_log, saved

from servosight.app.main import main
from servosight.models.core import InputError
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Column, Request, import_recording, parse_map


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
        (
            Request(),
            (
                "row 1",
                "among t, goal, pos is known to be the time or the command or the angle",
                "--map time=t:s --map command=goal:deg --map angle=pos:deg`",
                "other units",
            ),
        ),
        (Request(unit="rad"), ("--map time=t:s --map command=goal --map angle=pos --unit rad`",)),
        (
            Request(parse_map(["angle=pos:rad"])),
            ("the time or the command,", "--map angle=pos:rad --map time=t:s --map command=goal"),
        ),
        (Request({"time": Column("T")}), ("row 1", "no column T", "t, goal, pos", "--map")),
        (
            Request(parse_map(["time=t:ticks", "command=goal:deg", "angle=pos:deg"])),
            ("column t", "'ticks'", "s, ms, us"),
        ),
        (
            Request(parse_map(["time=t:ms", "command=pos:deg", "angle=pos:deg"])),
            ("column pos is mapped to command and angle both",),
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


def test_a_misspelt_quantity() -> None:
    with pytest.raises(InputError, match=r"tiem in tiem=t is no quantity \(did you mean time\?\)"):
        parse_map(["tiem=t"])


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


def test_ak80_in_two_tables(real_data: Path) -> None:
    place = real_data / "ak80"
    columns = parse_map(["time=time", "angle=position:rad", "command=position:rad"])
    request = Request(columns, command=place / "swingup_desired.csv")
    recording = import_recording(place / "swingup_measured.csv", request)
    assert recording.time_s.size == 1170
    assert recording.moved_range_deg == pytest.approx(287.7, abs=0.1)


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


@pytest.mark.parametrize("form", ["json", "csv"])
def test_a_command_with_a_clock_of_its_own_in_the_same_file(tmp_path: Path, form: str) -> None:
    """Columns of other lengths, which end in empty cells where they share a table."""
    t = [0.01 * i for i in range(100)]
    columns: dict[str, list[float]] = {
        "t": t,
        "pos": [float(i % 5) for i in range(100)],
        "tc": [1e3 * one for one in t[::4]],
        "goal": [float(i % 7) for i in range(25)],
    }
    path = tmp_path / "a.log"
    if form == "json":
        path.write_text(json.dumps(columns))
    else:
        cells = itertools.zip_longest(*columns.values(), fillvalue="")
        path.write_text("\n".join([",".join(columns), *(",".join(map(str, c)) for c in cells)]))
    words = ["time=t:s", "command_time=tc:ms", "command=goal:deg", "angle=pos:deg"]
    recording = import_recording(path, Request(parse_map(words)))
    assert recording.time_s.size == 100
    np.testing.assert_allclose(recording.command_time_s, t[::4])
    assert recording.command_deg.tolist() == columns["goal"]
    if form == "json":
        without = Request(parse_map([word for word in words if "tc" not in word]))
        refused(path, without, "25 values and t 100", "--map command_time=COLUMN")


def test_the_clock_of_a_command_in_a_file_of_its_own(tmp_path: Path) -> None:
    angle, command = tmp_path / "angle.csv", tmp_path / "command.csv"
    angle.write_text("\n".join(["t,pos", *(f"{0.01 * i},{i % 5}" for i in range(100))]))
    command.write_text("\n".join(["ms,goal", *(f"{40 * i},{i % 7}" for i in range(25))]))
    words = ["time=t:s", "command=goal:deg", "angle=pos:deg"]
    request = Request(parse_map(words), command=command)
    with pytest.raises(InputError, match=r"command.csv, row 1: no column t,.*--map command_time=t"):
        import_recording(angle, request)
    request = replace(request, columns=parse_map([*words, "command_time=ms:ms"]))
    recording = import_recording(angle, request)
    np.testing.assert_allclose(recording.command_time_s, 0.04 * np.arange(25))
