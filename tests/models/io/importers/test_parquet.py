"""Parquet files and data sets of LeRobot become recordings."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.foreign_logs import (
    COUNT,
    JOINT,
    JOINT_WORDS,
    MAKERS,
    PARQUET_MAP,
    bag,
    columns,
    is_sound,
    lerobot,
    parquet,
)
from support.refusal import refused

from servosight.app.main import main
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording
from servosight.sources import Options, read


def test_parquet(tmp_path: Path) -> None:
    path = parquet(tmp_path / "a.bin")
    is_sound(import_recording(path, PARQUET_MAP))
    refused(
        path, columns("time=stamp", "command=goal", "angle=x:rad"), "no column x", "state[0..1]"
    )
    words = "time=stamp:s", "'command=goal (rad)'", "angle=COLUMN"
    refused(path, Request(), "stamp, goal (rad), state[0..1]", *(f"--map {one}" for one in words))


def test_parquet_without_torque_at_the_end(tmp_path: Path) -> None:
    path = parquet(tmp_path / "a.bin", torque_enable=[n < 150 for n in range(COUNT)])
    recording = import_recording(path, PARQUET_MAP)
    assert recording.time_s.size == 150
    assert "torque_enable is false in 50 of 200 rows" in recording.notes[0]


@pytest.mark.parametrize("per_file", [1, 2])
def test_lerobot_data_sets(tmp_path: Path, per_file: int) -> None:
    folder = lerobot(tmp_path / "set", per_file=per_file)
    recording = import_recording(folder, JOINT)
    is_sound(recording)
    assert "episode 0 of 2" in recording.notes[0]
    assert "nominal" in recording.notes[0]
    again = read(
        folder,
        Options({"command": "action[1]:rad", "angle": "observation.state[elbow]:rad"}, part=1),
    )
    np.testing.assert_allclose(again.angle_deg, 2.0 * recording.angle_deg, rtol=1e-6)
    refused(folder, JOINT.__class__(JOINT.columns, part=2), "no episode 2", "its 2")
    refused(folder, columns("command=action[wrist]:rad"), "action[wrist]", "action[pan]")
    refused(folder, columns("command=action[elbo]:rad"), "did you mean action[elbow]?")
    refused(folder, columns("command=action[1]", "angle=observation.state[1]:rad"), "no unit")


@pytest.mark.parametrize("kind", ["lerobot", "rosbag"])
def test_a_joint_in_brackets_is_no_unit(tmp_path: Path, kind: str) -> None:
    """``--unit`` holds for it. Without any, the positions of JointState are in radians, as it is
    defined, and else degrees are assumed; a note says either."""
    folder = MAKERS[kind](tmp_path / "set")
    words = {
        "lerobot": ("command=action[elbow]", "angle=observation.state[elbow]"),
        "rosbag": ("command=/goal.position[elbow]", "angle=/joint_states.position[elbow]"),
    }[kind]
    is_sound(import_recording(folder, replace(columns(*words), unit="rad")))
    silent = import_recording(folder, columns(*words))
    said = {"lerobot": "no unit is given for", "rosbag": "is read in rad, as its message is"}[kind]
    assert any(said in note for note in silent.notes)
    if kind == "rosbag":
        is_sound(silent)
        degrees = import_recording(folder, replace(columns(*words), unit="deg"))
        np.testing.assert_allclose(np.rad2deg(degrees.angle_deg), silent.angle_deg)


def test_what_measured_the_angle_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a note where a name is that of a servo's own reading, unless the user has said it."""
    folder = bag(tmp_path / "bag", "MCAP")
    words = ("command=/goal.position[elbow]:rad", "angle=/joint_states.position[elbow]:rad")
    recording = import_recording(folder, columns(*words))
    assert recording.side == "surface"
    assert any("--angle-of sensor" in note for note in recording.notes)
    for side in ("surface", "sensor"):
        said = read(folder, Options(dict(word.split("=") for word in words), angle_of=side))
        assert said.side == side
        assert not any("--angle-of" in note for note in said.notes)
    maps = [part for word in JOINT_WORDS for part in ("--map", word)]
    data = str(lerobot(tmp_path / "set"))
    assert main(["import", data, *maps, "-o", str(tmp_path / "rec")]) == 0
    assert "own sensor; if it was measured at the surface" in capsys.readouterr().out
    assert load_recording(tmp_path / "rec").side == "sensor"


def test_the_dead_time_of_nominal_stamps_is_unknowable(tmp_path: Path) -> None:
    """Kept by the folder, and said by a fit: the sigma of the dead time is null."""
    from servosight.identify.fit import identify

    recording = import_recording(lerobot(tmp_path / "set"), JOINT)
    save_recording(recording, tmp_path / "rec")
    kept = load_recording(tmp_path / "rec")
    assert kept.notes == recording.notes
    assert kept.offset_sigma_s == recording.offset_sigma_s == math.inf
    fit = identify(kept, ["dead_time"], method="gradient")
    assert fit.parameters["dead_time.delay"].sigma is None
    assert any("nominal" in text for text in fit.warnings)
