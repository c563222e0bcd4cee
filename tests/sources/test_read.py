"""A path of any kind becomes a recording, in the same way for every caller."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import InputError, Recording
from servosight.sources import Options, read, read_all, read_log, unit_hint

T = np.arange(0.0, 2.0, 0.01)
RECORDING = Recording("made", T, 10.0 * np.sign(np.sin(9.0 * T)), T, 9.0 * np.sin(9.0 * T))


def written(path: Path, header: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="")
    return path


def test_a_recording_is_taken_as_it_is() -> None:
    assert read(RECORDING) is RECORDING


def test_folder_table_and_log_give_the_same(tmp_path: Path) -> None:
    RECORDING.save(tmp_path / "run")
    y, u = RECORDING.angle_deg, RECORDING.command_deg
    table = written(tmp_path / "run.csv", "time_s,command_deg,angle_deg", T, u, y)
    log = written(tmp_path / "log.txt", "t,goal,pos", 1e3 * T, np.radians(u), np.radians(y))
    columns = {"time": "t:ms", "command": "goal:rad", "angle": "pos:rad"}
    found = [
        *read_all([tmp_path / "run", str(table)]),
        read(log, Options(columns=columns)),
        read(log, Options(columns={**columns, "angle": "pos", "command": "goal"}, unit="rad")),
    ]
    for one in found:
        np.testing.assert_allclose(one.time_s, T, atol=1e-12)
        np.testing.assert_allclose(one.angle_deg, y, atol=1e-9)
        np.testing.assert_allclose(one.command_deg, u, atol=1e-9)


def test_one_path_is_several_recordings_too(tmp_path: Path) -> None:
    RECORDING.save(tmp_path / "run")
    assert [one.name for one in read_all(str(tmp_path / "run"))] == ["run"]
    assert read_all(()) == []


def test_a_log_of_another_program_needs_no_import_first(tmp_path: Path) -> None:
    entries = [
        {"timestamp": float(t), "position": float(y), "goal_position": float(u)}
        for t, y, u in zip(T, np.radians(RECORDING.angle_deg), RECORDING.command_deg, strict=True)
    ]
    log = tmp_path / "bam.json"
    log.write_text(json.dumps({"entries": entries}))
    np.testing.assert_allclose(read(log).angle_deg, RECORDING.angle_deg, atol=1e-9)
    assert read_log(log).time_s.size == T.size


def test_a_command_may_stand_in_a_table_of_its_own(tmp_path: Path) -> None:
    angle = written(tmp_path / "angle.csv", "time_s,angle_deg", T, RECORDING.angle_deg)
    command = written(tmp_path / "goal.csv", "time_s,command_deg", T, RECORDING.command_deg)
    found = read(angle, Options(command=command))
    np.testing.assert_allclose(found.angle_deg, RECORDING.angle_deg, atol=1e-9)
    np.testing.assert_allclose(found.command_deg, RECORDING.command_deg, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (Options(columns={"time": "t", "command": "goal", "angle": "nowhere"}), "nowhere"),
        (Options(columns={"colour": "pos"}), "colour"),
    ],
)
def test_columns_that_are_not_there_are_named(tmp_path: Path, options: Options, words: str) -> None:
    log = written(tmp_path / "log.csv", "t,goal,pos", T, T, T)
    with pytest.raises(InputError, match=words):
        read(log, options)


@pytest.mark.parametrize("name", ["gone", "gone.csv", "gone.json"])
def test_what_is_not_there_is_said_in_one_sentence(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="gone"):
        read(tmp_path / name)


def test_radians_are_doubted_not_refused() -> None:
    assert unit_hint(RECORDING) is None
    hint = unit_hint(replace(RECORDING, angle_deg=np.radians(RECORDING.angle_deg)))
    assert hint is not None
    assert "angle_rad" in hint


def test_read_errors_raise_no_doubt_about_radians() -> None:
    """Two samples that hold 57 times the command's range."""
    angle = RECORDING.angle_deg.copy()
    angle[100:102] += 57.0 * np.ptp(RECORDING.command_deg)
    assert unit_hint(replace(RECORDING, angle_deg=angle)) is None
