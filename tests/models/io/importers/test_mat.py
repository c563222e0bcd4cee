"""MAT files become recordings: those of the EMPS benchmark, and others by a map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from support.refusal import refused

from servosight.models.io import load_recording
from servosight.models.io.importers import Request, import_recording, parse_map


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
    refused(
        path, Request(), "--map time=out.time:s", "name of a column and its unit for COLUMN", names
    )


def test_samples_in_an_array_of_structs_and_columns_of_a_matrix(tmp_path: Path) -> None:
    t = 0.01 * np.arange(200)
    table = np.column_stack([t, np.sin(9 * t), np.sin(9 * t - 0.1)])
    kind = [(name, object) for name in ("t", "u", "y")]
    log = np.array([tuple(row) for row in table], dtype=kind)
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"log": log, "data": table})
    for words in (
        ["time=log.t:s", "command=log.u:rad", "angle=log.y:rad"],
        ["time=data[1]:s", "command=data[2]:rad", "angle=data[3]:rad"],
    ):
        recording = import_recording(path, Request(parse_map(words)))
        np.testing.assert_allclose(recording.time_s, t)
        np.testing.assert_allclose(recording.angle_deg, np.degrees(table[:, 2]))
    refused(path, Request(), "log.t, log.u, log.y, data[1..3]")


def test_bad_mat_files(tmp_path: Path) -> None:
    refused(mat_file(tmp_path / "a.mat", qm=np.ones(7)), Request(), "qm", "7 values", "200")
    refused(mat_file(tmp_path / "a.mat", qm="text"), Request(), "angle", "--map angle=COLUMN")
    bad = np.sin(np.arange(200.0))
    bad[4] = np.inf
    refused(mat_file(tmp_path / "a.mat", qm=bad), Request(), "sample 5", "qm", "finite")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file" + bytes(200))
    refused(tmp_path / "b.mat", Request(), "MATLAB", "-v7")


def test_emps_benchmark(real_data: Path) -> None:
    recording = import_recording(real_data / "emps" / "DATA_EMPS.mat", Request())
    assert recording.time_s.size == 24841
    assert recording.moved_range_deg == pytest.approx(24.64, abs=0.01)


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
