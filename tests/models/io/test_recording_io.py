"""Recordings from files: what is read, and the one sentence for what cannot be."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.recordings import ROWS, folder, refused, table, written

from servosight.models.core import InputError
from servosight.models.io import (
    inspect_folder,
    load_recording,
    save_recording,
)


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


def test_decimal_commas_in_quotes_between_commas(tmp_path: Path) -> None:
    plain = load_recording(written(tmp_path / "plain.csv", table()))
    rows = [[f'"{cell.replace(".", ",")}"' for cell in line.split(",")] for line in table()]
    other = load_recording(written(tmp_path / "other.csv", [",".join(cells) for cells in rows]))
    np.testing.assert_array_equal(plain.angle_deg, other.angle_deg)
    np.testing.assert_array_equal(plain.time_s, other.time_s)


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
