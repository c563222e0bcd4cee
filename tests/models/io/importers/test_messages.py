"""Logs of messages become recordings: PX4's ULog, and bags of ROS 2."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from support.foreign_logs import COUNT, bag, columns, is_sound, ulog
from support.refusal import refused

from servosight.models.io.importers import Request, import_recording


def test_px4_logs(tmp_path: Path) -> None:
    pytest.importorskip("pyulog")
    path = ulog(tmp_path / "flight")
    words = ("command=servo_setpoint.position[1]:rad", "angle=servo_status[1].position:rad")
    is_sound(import_recording(path, columns(*words)))
    (note,) = import_recording(path, columns(*words)).notes
    assert "column servo_status.load_torque is not used" in note
    maps = "--map command=COLUMN:UNIT --map angle=COLUMN:UNIT"
    refused(path, Request(), maps, "servo_setpoint.position[0..1]")
    refused(
        path, columns(words[0], "angle=servo_status.x:rad"), "servo_status.x", "[1].load_torque"
    )
    refused(path, columns("time=timestamp", *words), "--map time", "leave it out")


def test_a_px4_log_without_torque_at_the_end_is_cut(tmp_path: Path) -> None:
    """The flag is that of the angle's topic; the command stays whole."""
    pytest.importorskip("pyulog")
    words = ("command=servo_setpoint.position[1]:rad", "angle=servo_status[1].position:rad")
    recording = import_recording(ulog(tmp_path / "flight", on=150), columns(*words))
    assert (recording.time_s.size, recording.command_time_s.size) == (150, COUNT)
    assert "torque_enable is false in 50 of 200 messages" in recording.notes[-1]


def test_a_px4_log_that_was_cut_off_says_so(tmp_path: Path) -> None:
    pytest.importorskip("pyulog")
    path = ulog(tmp_path / "flight")
    request = columns(
        "command=servo_setpoint.position[1]:rad", "angle=servo_status[1].position:rad"
    )
    content = path.read_bytes()
    for lost in (1, 20, 2010):
        path.write_bytes(content[:-lost])
        recording = import_recording(path, request)
        assert "the end of the file is missing" in recording.notes[0]
        assert COUNT // 2 < recording.time_s.size < COUNT


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
def test_ros_2_bags(tmp_path: Path, storage: str) -> None:
    """The folder, and the one file in it under another name; stamps are those of the headers."""
    folder = bag(tmp_path / "bag", storage)
    request = columns(
        "command=/goal.position[elbow]:rad", "angle=/joint_states.position[elbow]:rad"
    )
    recording = import_recording(folder, request)
    is_sound(recording)
    assert recording.details["source"]["clock"] == "header.stamp"
    assert "columns /load.wrench.force.x, /load.wrench.force.y" in recording.notes[0]
    (file,) = (entry for entry in folder.iterdir() if entry.name != "metadata.yaml")
    is_sound(import_recording(file, request))
    is_sound(import_recording(file.rename(tmp_path / "run.log"), request))
    folder = bag(tmp_path / "again", storage)
    refused(folder, columns("command=/goal.position[x]:rad"), "angle", "/goal.position[pan]")
    refused(folder, Request(), "--map command=COLUMN --map angle=COLUMN`")  # the unit is known


def test_a_bag_that_was_cut_off_is_read_to_there(tmp_path: Path) -> None:
    """Within the messages, and between them and the summary behind them."""
    (file,) = bag(tmp_path / "bag", "MCAP").glob("*.mcap")
    request = columns(
        "command=/goal.position[elbow]:rad", "angle=/joint_states.position[elbow]:rad"
    )
    whole = import_recording(file, request)
    content = file.read_bytes()
    for kept, least in ((0.6, COUNT // 2), (0.9999, COUNT)):
        file.write_bytes(content[: int(kept * len(content))])
        recording = import_recording(file, request)
        assert any("the end of the file is missing" in note for note in recording.notes)
        size = recording.time_s.size
        assert least <= size <= COUNT
        np.testing.assert_array_equal(recording.angle_deg, whole.angle_deg[:size])
    file.write_bytes(content[:200])
    refused(file, request, "a whole bag")


@pytest.mark.parametrize(
    ("profile", "words"), [("", "without a profile"), ("ros1", "with the profile 'ros1'")]
)
def test_an_mcap_file_of_another_program_gets_advice_that_fits(
    tmp_path: Path, profile: str, words: str
) -> None:
    """The header by the format's own rules: profile and library."""
    pytest.importorskip("rosbags")
    texts = [struct.pack("<I", len(one)) + one.encode() for one in (profile, "another program")]
    header = b"".join(texts)
    path = tmp_path / "a.log"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + struct.pack("<Q", len(header)) + header + bytes(90))
    request = columns("command=/pos.x:rad", "angle=/pos.y:rad")
    refused(path, request, words, "messages of ROS 2", "as CSV files")
