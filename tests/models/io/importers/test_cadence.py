"""Clocks that begin again, coarse clocks, gaps and bursts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.refusal import refused

from servosight.models.core import Array, Recording
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording, parse_map

T = 0.01 * np.arange(200)


def read(path: Path, stamps: Array, unit: str = "s") -> Recording:
    """A log of a sine at those stamps."""
    rows = [
        f"{stamp!r},{math.sin(9 * t)},{math.sin(9 * t - 0.2)}"
        for stamp, t in zip(stamps.tolist(), T.tolist(), strict=True)
    ]
    path.write_text("\n".join(["t,command_deg,angle_deg", *rows]))
    return import_recording(path, Request(parse_map([f"time=t:{unit}"])))


@pytest.mark.parametrize(
    ("period", "unit", "per_s"), [(1 << 16, "ms", 1e3), (1 << 32, "us", 1e6), (86400, "s", 1.0)]
)
def test_a_counter_that_begins_again_rises_on(
    tmp_path: Path, period: int, unit: str, per_s: float
) -> None:
    recording = read(tmp_path / "a.csv", np.round((T - 0.5) * per_s, 3) % period, unit)
    np.testing.assert_allclose(recording.time_s - recording.time_s[0], T, atol=1e-6)
    (note,) = recording.notes
    assert "begins again at zero 1 time, at row 52 for the first time" in note
    assert str(period) in note


def test_a_clock_that_is_set_back_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"row 102.*runs back.*cut it here if the clock was set"):
        read(tmp_path / "a.csv", np.where(T < 0.995, T, T - 0.5))


def test_a_gap_is_said_where_the_command_is_missing_in_it(tmp_path: Path) -> None:
    (note,) = read(tmp_path / "a.csv", np.where(T < 0.995, T, T + 3.0)).notes
    assert "between row 101 and row 102 the log has no rows for 3.01 s; the command" in note
    assert read(tmp_path / "a.csv", T).notes == ()


@pytest.mark.parametrize("size", [2, 4])
def test_rows_that_arrive_in_bursts_are_said(tmp_path: Path, size: int) -> None:
    place = np.arange(T.size)
    stamps = 0.01 * (size * (place // size)) + 2e-5 * (place % size)
    (note,) = read(tmp_path / "a.csv", stamps).notes
    assert "arrived in bursts" in note
    jitter = T + np.random.default_rng(1).uniform(-0.004, 0.004, T.size)
    assert read(tmp_path / "a.csv", jitter).notes == ()


def test_a_coarse_clock_leaves_the_offset_uncertain(tmp_path: Path) -> None:
    """Samples of one stamp may have been taken anywhere within the tick."""
    recording = read(tmp_path / "a.csv", np.floor(T / 0.03 + 1e-9) * 0.03)
    assert recording.offset_sigma_s == pytest.approx(0.03 / math.sqrt(12.0), rel=0.01)
    save_recording(recording, tmp_path / "rec")
    assert load_recording(tmp_path / "rec").offset_sigma_s == recording.offset_sigma_s
    rows = [f"{i // 100},{i % 7},{i % 5}" for i in range(1000)]
    (tmp_path / "a.csv").write_text("\n".join(["time_s,command_deg,angle_deg", *rows]))
    refused(tmp_path / "a.csv", Request(), "1,000 rows and 10 different stamps", "finer")


def test_seconds_that_are_read_as_milliseconds_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"spans 0[.]00199 s, expected at least 0[.]04 s"):
        read(tmp_path / "a.csv", T, "ms")


def test_a_clock_without_its_unit_gets_the_map_to_write(tmp_path: Path) -> None:
    with pytest.raises(Exception, match="--map time=t:ms"):
        read(tmp_path / "a.csv", 1e3 * T)
