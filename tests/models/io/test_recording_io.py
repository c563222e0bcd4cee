"""Recordings from files: what is read, and the one sentence for what cannot be."""

from __future__ import annotations

import math
import os
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from servosight.models.core import InputError, Recording, new_folder, write_text
from servosight.models.io import (
    inspect_folder,
    load_recording,
    read_sheet,
    save_recording,
    set_keys,
    table_text,
)

ROWS = 80


def table(
    header: str = "time_s,command_deg,angle_deg", rows: int = ROWS, time: float = 0.01
) -> list[str]:
    """A sound recording as lines: a sine command, an angle a little behind."""
    body = [
        f"{i * time:.6g},{10 * math.sin(0.3 * i):.6f},{10 * math.sin(0.3 * i - 0.2):.6f}"
        for i in range(rows)
    ]
    return [header, *body]


def written(path: Path, lines: list[str], end: str = "\n") -> Path:
    path.write_bytes((end.join(lines) + end).encode())
    return path


def folder(
    tmp_path: Path,
    *,
    command: list[str] | None = None,
    angle: list[str] | None = None,
    toml: str | None = None,
) -> Path:
    """A recording's folder; sound where nothing else is given."""
    place = tmp_path / "rec"
    place.mkdir()
    sound = [line.split(",") for line in table()[1:]]
    written(
        place / "command.csv",
        command or ["time_s,command_deg", *(f"{t},{u}" for t, u, _ in sound)],
    )
    written(place / "angle.csv", angle or ["time_s,angle_deg", *(f"{t},{y}" for t, _, y in sound)])
    if toml is not None:
        (place / "recording.toml").write_text(toml)
    return place


def with_row(number: int, text: str) -> list[str]:
    """A sound table whose line ``number`` of the file (1-based) is replaced."""
    lines = table()
    lines[number - 1] = text
    return lines


def refused(path: Path, *words: str) -> None:
    """Loading fails with one sentence that holds every word."""
    with pytest.raises(InputError) as caught:
        load_recording(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    for word in (path.name, "expected", *words):
        assert word in sentence, sentence


# --- what is read ---------------------------------------------------------------------------


def test_single_csv(tmp_path: Path) -> None:
    recording = load_recording(written(tmp_path / "log.csv", table()))
    assert recording.name == "log"
    assert recording.hold == "zero"
    assert recording.sigma_deg is None
    np.testing.assert_array_equal(recording.time_s, recording.command_time_s)
    assert recording.time_s[3] == 0.03
    assert recording.angle_deg.shape == (ROWS,)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_byte_order_mark(tmp_path: Path, end: str) -> None:
    plain = load_recording(written(tmp_path / "plain.csv", table()))
    lines = table()
    lines[0] = "\ufeff" + lines[0]
    other = load_recording(written(tmp_path / "other.csv", lines, end))
    np.testing.assert_array_equal(plain.angle_deg, other.angle_deg)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_other_separators_with_decimal_commas(tmp_path: Path, mark: str) -> None:
    plain = load_recording(written(tmp_path / "plain.csv", table()))
    lines = [line.replace(",", mark).replace(".", ",") for line in table()]
    other = load_recording(written(tmp_path / "other.csv", lines))
    np.testing.assert_array_equal(plain.angle_deg, other.angle_deg)


def test_quotes_notes_and_blank_lines(tmp_path: Path) -> None:
    lines = table("time_s,command_deg,angle_deg,note")
    lines = [lines[0], *(f'{line},"left, then right"' for line in lines[1:])]
    recording = load_recording(written(tmp_path / "log.csv", [*lines[:5], "", *lines[5:], ""]))
    assert recording.angle_deg.shape == (ROWS,)


@pytest.mark.parametrize(("unit", "per_second"), [("ms", 1e3), ("us", 1e6)])
def test_clock_in_other_units(tmp_path: Path, unit: str, per_second: float) -> None:
    lines = table(f"time_{unit},command_deg,angle_deg", time=0.008 * per_second)
    recording = load_recording(written(tmp_path / "log.csv", lines))
    assert recording.time_s[1] == 0.008
    assert recording.duration_s == pytest.approx(0.008 * (ROWS - 1))


def test_radians(tmp_path: Path) -> None:
    degrees = load_recording(written(tmp_path / "deg.csv", table()))
    radians = load_recording(written(tmp_path / "rad.csv", table("time_s,command_rad,angle_rad")))
    np.testing.assert_allclose(np.rad2deg(degrees.angle_deg), radians.angle_deg, rtol=1e-14)
    np.testing.assert_allclose(np.rad2deg(degrees.command_deg), radians.command_deg, rtol=1e-14)


def test_pulse_widths(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", table("time_s,command_us,angle_deg"))
    recording = load_recording(path, deg_per_us=0.1, neutral_us=1500.0)
    plain = load_recording(written(tmp_path / "plain.csv", table()))
    np.testing.assert_allclose(recording.command_deg, 0.1 * (plain.command_deg - 1500.0))
    refused(path, "command_us", "--deg-per-us", "--neutral-us")


def test_folder_with_settings(tmp_path: Path) -> None:
    place = folder(
        tmp_path,
        toml='format = 1\nservo = "MG90S"\nhold = "linear"\nvideo_offset_s = 0.5\n'
        "unit_scale = 2.0\nrelative_gain = 4.0\nrelative_load = 0.5\n"
        "[camera]\nexposure_s = 0.004\nwidth = 640\n",
    )
    recording = load_recording(place)
    plain = load_recording(written(tmp_path / "plain.csv", table()))
    assert recording.name == "rec"
    assert recording.hold == "linear"
    assert recording.exposure_s == 0.004
    assert (recording.relative_gain, recording.relative_load) == (4.0, 0.5)
    assert recording.details["servo"] == "MG90S"
    np.testing.assert_array_equal(recording.angle_deg, 2.0 * plain.angle_deg)
    np.testing.assert_array_equal(recording.command_deg, 2.0 * plain.command_deg)
    np.testing.assert_array_equal(recording.time_s, plain.time_s)  # the angle's clock is right
    assert inspect_folder(place).settings.video_offset_s == 0.5


@pytest.mark.parametrize("toml", ['command_hold = "linear"', '[command]\nhold = "linear"'])
def test_hold_by_its_other_names(tmp_path: Path, toml: str) -> None:
    assert load_recording(folder(tmp_path, toml=toml)).hold == "linear"


def test_sigma_and_rows_of_their_own(tmp_path: Path) -> None:
    place = folder(
        tmp_path,
        command=["time_s,command_deg", "-1,0", "0.2,5"],
        angle=["time_s,angle_rad,sigma_rad", *(f"{0.01 * i},{i},0.5" for i in range(60))],
    )
    recording = load_recording(place)
    assert recording.command_deg.tolist() == [0.0, 5.0]
    assert recording.sigma_deg is not None
    np.testing.assert_allclose(recording.sigma_deg, math.degrees(0.5))


def test_video_without_angle_asks_for_tracking(tmp_path: Path) -> None:
    place = folder(tmp_path)
    assert not inspect_folder(place).needs_tracking
    (place / "video.mkv").write_bytes(b"")
    (place / "angle.csv").unlink()
    assert inspect_folder(place).needs_tracking
    refused(place, "angle.csv", "servosight track")


# --- what is refused ------------------------------------------------------------------------

SINGLE: dict[str, tuple[list[str], tuple[str, ...]]] = {
    "missing column": (table("time_s,command_deg,angle"), ("row 1", "angle_deg", "--map")),
    "no header": (["0,0,0", *table()[1:]], ("row 1", "names of the 3 columns")),
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
    "separators at the end": (
        [table()[0], *(f"{row}," for row in table()[1:])],
        ("row 1", "ends with a separator", "end the header"),
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
        (b"time_s,command_deg,angle_deg\n0,1,2\n0,\xe9,2\n", ("row 3", "0xe9", "UTF-8")),
        ("time_s,angle_deg\n".encode("utf-16"), ("row 1", "UTF-8")),
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


def test_notes_of_the_users_own_are_kept(tmp_path: Path) -> None:
    place = folder(tmp_path, toml='what = "a fin"\ndate = 2024-05-01\n[servo]\nkind = "analog"')
    assert load_recording(place).details["servo"] == {"kind": "analog"}


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


# --- properties -----------------------------------------------------------------------------

NUMBER = st.floats(-1e4, 1e4, allow_nan=False)


@settings(max_examples=30)
@given(
    angle=hnp.arrays(np.float64, 50, elements=NUMBER, unique=True),
    step=st.floats(1e-3, 0.5),
    origin=st.floats(-1e3, 1e9),
    sigma=st.none() | st.floats(1e-9, 10.0),
    hold=st.sampled_from(["zero", "linear"]),
)
def test_round_trip_is_exact(
    tmp_path_factory: pytest.TempPathFactory,
    angle: np.ndarray,
    step: float,
    origin: float,
    sigma: float | None,
    hold: str,
) -> None:
    time_s = origin + step * np.arange(50.0)
    given_recording = Recording(
        name="rec",
        command_time_s=time_s[::2],
        command_deg=angle[::2],
        time_s=time_s,
        angle_deg=angle,
        sigma_deg=None if sigma is None else np.full(50, sigma),
        hold="linear" if hold == "linear" else "zero",
        exposure_s=0.0005,
        details={"source": {"name": 'härd "quoted"\n', "mass": 0.49}},
    )
    place = tmp_path_factory.mktemp("round") / "rec"
    save_recording(given_recording, place, extra={"what": "a test"})
    read = load_recording(place)
    for name in ("command_time_s", "command_deg", "time_s", "angle_deg"):
        np.testing.assert_array_equal(getattr(read, name), getattr(given_recording, name))
    if sigma is None:
        assert read.sigma_deg is None
    else:
        np.testing.assert_array_equal(read.sigma_deg, given_recording.sigma_deg)
    assert (read.name, read.hold, read.exposure_s) == ("rec", hold, 0.0005)
    assert read.details["source"] == given_recording.details["source"]
    assert read.details["what"] == "a test"


@settings(max_examples=200)
@given(st.binary(max_size=300))
def test_any_bytes_give_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    never_crashes(tmp_path_factory.mktemp("bytes") / "log.csv", data)


CELL = st.text(max_size=8) | NUMBER.map(repr) | st.sampled_from(["nan", "1e999", "-0", "0x1", '"'])


@settings(max_examples=200)
@given(
    rows=st.lists(st.lists(CELL, min_size=3, max_size=3), max_size=4),
    mark=st.sampled_from([",", ";", "\t"]),
)
def test_any_text_gives_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, rows: list[list[str]], mark: str
) -> None:
    body = [line.split(",") for line in table()[1:]]
    lines = [mark.join(row) for row in [["time_s", "command_deg", "angle_deg"], *body, *rows]]
    data = "\n".join(lines).encode("utf-8", "surrogatepass")
    never_crashes(tmp_path_factory.mktemp("text") / "log.csv", data)


@settings(max_examples=100)
@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda b: b.decode("latin-1")))
def test_any_settings_give_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    place = folder(tmp_path_factory.mktemp("toml"))
    (place / "recording.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert "recording.toml" in (complaint(place) or "recording.toml")


def never_crashes(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    sentence = complaint(path)
    if sentence is not None:
        assert str(path) in sentence
        return
    recording = load_recording(path)
    assert np.isfinite(recording.angle_deg).all()
    assert (np.diff(recording.time_s) > 0).all()


def complaint(path: Path) -> str | None:
    """The sentence with which a recording is refused; None where it is read."""
    try:
        load_recording(path)
    except InputError as error:
        return str(error)
    return None


@given(hnp.arrays(np.float64, (7, 2), elements=st.floats(allow_nan=False, allow_infinity=False)))
def test_tables_read_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, numbers: np.ndarray
) -> None:
    path = tmp_path_factory.mktemp("table") / "table.csv"
    write_text(path, table_text(("a", "b"), (numbers[:, 0], numbers[:, 1])))
    np.testing.assert_array_equal(read_sheet(path).columns(["a", "b"]), numbers)


# --- whole or not at all --------------------------------------------------------------------


def stop(fresh: Path) -> None:
    write_text(fresh / "a", "half")
    raise RuntimeError("stop")


def fails(place: Path, replaceable: tuple[str, ...]) -> None:
    stopped = pytest.raises(RuntimeError, match="stop")
    with stopped, new_folder(place, replaceable, force=True) as fresh:
        stop(fresh)


def test_a_folder_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    place = tmp_path / "deep" / "rec"
    fails(place, ())
    assert not place.exists()
    with new_folder(place, ()) as fresh:
        write_text(fresh / "a", "1")
    fails(place, ("a",))
    assert (place / "a").read_text() == "1"
    with new_folder(place, ("a",), sign="a") as fresh:
        write_text(fresh / "b", "3")
    assert [entry.name for entry in place.iterdir()] == ["b"]
    assert [entry.name for entry in place.parent.iterdir()] == ["rec"]


def test_a_users_file_is_never_replaced_by_a_recording(tmp_path: Path) -> None:
    place = tmp_path / "rec"
    place.mkdir()
    (place / "thesis.tex").write_text("years of work")
    recording = load_recording(written(tmp_path / "log.csv", table()))
    with pytest.raises(InputError, match=r"thesis\.tex"):
        save_recording(recording, place)
    assert (place / "thesis.tex").exists()


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.*cannot be written"):
        write_text(tmp_path / "nowhere" / "a.txt", "1")
    (tmp_path / "file").write_text("1")
    with (
        pytest.raises(InputError, match="cannot be written"),
        new_folder(tmp_path / "file" / "rec", ()),
    ):
        pass


def test_a_link_is_written_through(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_text(tmp_path / "link", "1")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "1"


def test_a_horn_beside_the_angle(tmp_path: Path) -> None:
    """Rows and times of its own; kept when saved; absent where there is no file."""
    place = folder(tmp_path)
    assert load_recording(place).horn is None
    rows = [f"{0.02 * i:.6g},{math.sin(0.6 * i):.6f},0.01" for i in range(60)]
    written(place / "horn.csv", ["time_s,angle_deg,sigma_deg", *rows])

    recording = load_recording(place)

    assert recording.horn is not None
    assert recording.horn.angle_deg.shape == (60,)
    assert recording.horn.time_s[3] == 0.06
    assert recording.horn.sigma_deg is not None
    save_recording(recording, tmp_path / "again")
    again = load_recording(tmp_path / "again").horn
    assert again is not None
    np.testing.assert_array_equal(again.angle_deg, recording.horn.angle_deg)


def test_a_horn_that_is_none(tmp_path: Path) -> None:
    place = folder(tmp_path)
    written(place / "horn.csv", ["time_s,angle_deg", "0,1", "0.01,x"])
    with pytest.raises(InputError, match=r"horn\.csv.*expected"):
        load_recording(place)


def test_keys_are_set_and_the_authors_words_stay(tmp_path: Path) -> None:
    """Comments, order and layout stay; text with quotes is kept as text."""
    file = tmp_path / "recording.toml"
    words = "# my servo\nformat = 1  # the first\nvideo_offset_s = 0.1 # by eye\n\n[camera]\n"
    more = 'note = """\nvideo_offset_s = 9\n"""\nvideo_offset_s = 3 # another\n'
    file.write_text(words + more, encoding="utf-8-sig")
    set_keys(file, video_offset_s=0.25, clock_note='the "light" says so')
    text = file.read_text(encoding="utf-8")
    assert text.endswith(words.replace("0.1", "0.25") + more)
    read = tomllib.loads(text)
    assert read["clock_note"] == 'the "light" says so'
    assert read["video_offset_s"] == 0.25
    assert read["camera"]["video_offset_s"] == 3
    set_keys(tmp_path / "new.toml", offset_sigma_s=float("inf"))
    assert tomllib.loads((tmp_path / "new.toml").read_text()) == {
        "offset_sigma_s": float("inf"),
        "format": 1,
    }


# --- what is known of the set-up ------------------------------------------------------------

SETUP = (
    "[setup]\nsupply_v = 7.4\nload_kg = 0.5\narm_m = 0.1\nloop_gain = 100\n"
    "[reference]\nload_kg = 0.25\narm_m = 0.2\nloop_gain = 400\n"
)


def test_gain_and_load_follow_from_the_setup(tmp_path: Path) -> None:
    """They are relative to the reference, and stay so when the recording is written again."""
    recording = load_recording(folder(tmp_path, toml=SETUP))
    assert (recording.relative_gain, recording.relative_load) == (0.25, 1.0)
    save_recording(recording, tmp_path / "again")
    again = load_recording(tmp_path / "again")
    assert (again.relative_gain, again.relative_load) == (0.25, 1.0)
    assert again.details["setup"] == recording.details["setup"]


@pytest.mark.parametrize(
    ("toml", "gain"),
    [(f"relative_gain = 2.0\n{SETUP}", 2.0), ("[setup]\nloop_gain = 100\n", 1.0)],
)
def test_a_stated_gain_or_a_lone_setup(tmp_path: Path, toml: str, gain: float) -> None:
    assert load_recording(folder(tmp_path, toml=toml)).relative_gain == gain


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ("[setup]\nsupply_v = -1\n", ("setup.supply_v", "-1", "volts")),
        ('[setup]\nload_kg = "x"\n', ("setup.load_kg", "kilograms", "0.49")),
        ("[setup]\nsuply_v = 7\n", ("setup.suply_v", "setup.supply_v")),
        ("[setup]\nloop_gain = 1\n[reference]\nloop_gain = 1e6\n", ("setup", "1e-06", "0.001")),
    ],
)
def test_a_wrong_setup_is_refused(tmp_path: Path, toml: str, words: tuple[str, ...]) -> None:
    refused(folder(tmp_path, toml=toml), "recording.toml", *words)
