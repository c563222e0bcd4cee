"""Logs of bam become recordings, or are refused with one sentence."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.refusal import refused
from support.written_logs import bam_log, saved

from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording


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
        (broken(7, position=math.inf), ("entry 7", "position", "finite")),
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
