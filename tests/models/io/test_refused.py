"""Recordings that cannot be read: the one sentence that names file, row and remedy."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.recordings import folder, refused, table, with_row, written

SINGLE: dict[str, tuple[list[str], tuple[str, ...]]] = {
    "missing column": (table("time_s,command_deg,angle"), ("row 1", "angle_deg", "--map")),
    "other names": (
        table("t [ms],Goal Position [deg],measured"),
        (
            "row 1",
            "time_s",
            "--map 'time=t [ms]' --map 'command=Goal Position [deg]' "
            "--map angle=measured:deg` on the command line",
        ),
    ),
    "two of a name": (table("t,goal_a,goal_b"), ("row 1", "--map time=COLUMN:s`")),
    "misspelt": (
        table("time_s,comand_deg,angle_deg"),
        ("row 1", "--map command=comand_deg`"),
    ),
    "no header": (["0,0,0", *table()[1:]], ("without a header", "time_s", "1, 2, 3", "--map")),
    "text": (with_row(7, "0.05,left,3"), ("row 7", "command_deg", "'left'", "number", "correct")),
    "empty cell": (with_row(7, "0.05,,3"), ("row 7", "command_deg", "empty", "number")),
    "underscore": (with_row(7, "0.05,1_0,3"), ("row 7", "command_deg", "number")),
    "nan": (with_row(9, "0.07,1,nan"), ("row 9", "angle_deg", "nan", "finite", "correct")),
    "inf": (with_row(9, "0.07,-inf,1"), ("row 9", "command_deg", "inf", "finite", "correct")),
    "time is nan": (with_row(9, "nan,1,1"), ("row 9", "time_s", "finite")),
    "time stands still": (with_row(5, "0.02,1,1"), ("row 5", "time_s", "stands still", "rising")),
    "time runs back": (with_row(5, "0.001,1,1"), ("row 5", "time_s", "runs back", "sort")),
    "too few": (table(rows=49), ("49 samples", "at least 50", "longer")),
    "no rows": (table(rows=0), ("0 samples", "at least 50")),
    "duplicate": (table("time_s,angle_deg,angle_deg"), ("row 1", "angle_deg", "twice", "remove")),
    "two units": (
        ["time_s,command_deg,angle_deg,angle_rad", *(f"{r},1" for r in table()[1:])],
        ("angle_deg and angle_rad", "remove"),
    ),
    "no index name": (
        [table()[0], *(f"{n},{row}" for n, row in enumerate(table()[1:]))],
        ("row 1", "3 names", "4 fields", "index,time_s,command_deg"),
    ),
    "narrow row": (with_row(11, "0.09,1"), ("row 11", "2 fields", "3", "correct")),
    "wide row": (with_row(11, "0.09,1,2,3"), ("row 11", "4 fields", "3", "correct")),
    "command at rest": (
        ["time_s,command_deg,angle_deg", *(f"{0.01 * i},5,{i}" for i in range(60))],
        ("command_deg", "never moves", "5 deg", "steps"),
    ),
    "angle at rest": (
        ["time_s,command_deg,angle_deg", *(f"{0.01 * i},{i},5" for i in range(60))],
        ("angle_deg", "5 in every row", "moves", "sensor"),
    ),
    "huge angle": (with_row(20, "0.185,1,2e5"), ("row 20", "angle_deg", "unit", "degrees")),
    "clock in ms at 120 Hz": (table(time=8.333), ("time_s", "8.33 s", "time_ms")),
    "clock in ms at 1 kHz": (table(time=1.0), ("time_s", "1 s", "time_ms")),
    "clock in us": (table(time=1e5), ("time_s", "1e+05", "time_us")),
    "clock in hours": (table(time=1e-7), ("time_s", "unit")),
    "sigma of zero": (
        ["time_s,command_deg,angle_deg,sigma_deg", *(f"{r},0" for r in table()[1:])],
        ("row 2", "sigma_deg", "above 0"),
    ),
    "short row": (with_row(4, "1"), ("row 4", "the row has 1 field,")),
    "quotes": (with_row(4, '0.02,"1,1'), ("row 4", "quotes", "remove")),
    "long row": (with_row(4, "1" * 200_000), ("row 4", "200000 characters", "table")),
}


@pytest.mark.parametrize("case", SINGLE)
def test_bad_single_csv(tmp_path: Path, case: str) -> None:
    lines, words = SINGLE[case]
    refused(written(tmp_path / "log.csv", lines), *words)


def test_row_numbers_count_blank_lines(tmp_path: Path) -> None:
    lines = ["", *with_row(7, "0.05,left,3")]
    refused(written(tmp_path / "log.csv", lines), "row 8")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ("empty", "header")),
        (b"\n \r\n\n", ("empty", "header")),
        (b"time_s,command_deg,angle_deg\n0,1,2\n0,\xe9,2\n", ("row 3", "'\xe9'", "number")),
        (b"time_s,command_deg,angle_deg\n0,1,2\n0,\x81,2\n", ("row 3", "0x81", "UTF-8")),
        (b"\xff\xfet", ("row 1", "0x74", "UTF-8")),
        (b"time_s,command_deg,angle_deg\n01/03/2026 9:05,1,2\n", ("row 2", "date such as 2026")),
        (b'time_s,command_deg,angle_deg\n"4,000",1,2\n', ("row 2", "separators of thousands")),
    ],
)
def test_bytes_that_are_no_table(tmp_path: Path, data: bytes, words: tuple[str, ...]) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    refused(path, *words)


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ("format = 2", ("key format", "2", "1", "update")),
        ("format = true", ("key format",)),
        ('format = "1"', ("key format",)),
        ("hold = 'first'", ("key hold", "zero", "linear")),
        ("unit_scal = 2.0", ("unknown key unit_scal", "unit_scale", "rename")),
        ("video_offset = 2.0", ("unknown key video_offset", "video_offset_s")),
        ("unit_scale = 0", ("key unit_scale", "0")),
        ("unit_scale = inf", ("key unit_scale", "finite")),
        ("offset_sigma_s = -0.001", ("key offset_sigma_s", "-0.001", "from 0 on")),
        ("video_offset_s = 'late'", ("key video_offset_s", "'late'", "number")),
        ('angle_of = "motor"', ("key angle_of", '"surface" or "sensor"')),
        ("relative_gain = 0", ("key relative_gain", "0.001 to 1000")),
        ("relative_load = -1", ("key relative_load", "0 to 1000")),
        ("relative_gains = 2", ("unknown key relative_gains", "relative_gain")),
        ("camera = 3", ("key camera", "table")),
        ("[camera]\nexposure_s = -0.001", ("camera.exposure_s", "-0.001", "seconds")),
        ("[camera]\nexposure_s = 8", ("camera.exposure_s", "8", "0.008")),
        ("[camera]\nexposure_s = 0.5", ("camera.exposure_s", "0.5", "between samples")),
        ("[camera]\nexposure_ms = 8", ("unknown key camera.exposure_ms", "camera.exposure_s")),
        ("format = \n", ("no TOML", "line 1")),
        ("a = " + "[" * 5000, ("no TOML",)),
    ],
)
def test_bad_settings(tmp_path: Path, toml: str, words: tuple[str, ...]) -> None:
    refused(folder(tmp_path, toml=toml), "recording.toml", *words)


def test_settings_that_are_not_text(tmp_path: Path) -> None:
    place = folder(tmp_path)
    (place / "recording.toml").write_bytes(b"name = '\xff'")
    refused(place, "recording.toml", "TOML")


def test_streams_without_overlap(tmp_path: Path) -> None:
    angle = ["time_s,angle_deg", *(f"{100 + 0.01 * i},{i}" for i in range(60))]
    refused(folder(tmp_path, angle=angle), "angle.csv", "without overlap", "one clock", "shift")


def test_command_that_moves_only_after_the_angle(tmp_path: Path) -> None:
    command = ["time_s,command_deg", "0,0", "0.5,0", "5,10"]
    refused(folder(tmp_path, command=command), "command.csv", "never moves")


def test_command_without_rows(tmp_path: Path) -> None:
    refused(folder(tmp_path, command=["time_s,command_deg"]), "command.csv", "no rows", "write")


@pytest.mark.parametrize("missing", ["command.csv", "angle.csv"])
def test_folder_without_a_file(tmp_path: Path, missing: str) -> None:
    place = folder(tmp_path)
    (place / missing).unlink()
    refused(place, missing, "no such file", "servosight import")


def test_names_that_lead_nowhere(tmp_path: Path) -> None:
    refused(tmp_path / "nothing", "no such file")
    for name in ("log.json", "log.mat"):
        (tmp_path / name).write_bytes(b"{}")
        refused(tmp_path / name, "servosight import")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.csv")
        refused(tmp_path / "pipe.csv", "no file")
