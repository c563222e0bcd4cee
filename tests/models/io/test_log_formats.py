"""Formats of other programs' logs: recognised by content, read, or refused with one sentence."""

from __future__ import annotations

import json
import math
import shutil
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.refusal import refused

from servosight.app.main import main
from servosight.models.core import Recording
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording, parse_map, recognised
from servosight.models.io.importers import _apart as apart
from servosight.sources import Options, read

COUNT, STEP_S = 200, 0.01
TIMES = [STEP_S * i for i in range(COUNT)]
GOAL = [0.3 * math.sin(9.0 * t) for t in TIMES]
POSITION = [0.3 * math.sin(9.0 * t - 0.2) for t in TIMES]


def columns(*words: str) -> Request:
    return Request(parse_map(words))


def is_sound(recording: Recording) -> None:
    """The numbers above, from whatever file."""
    np.testing.assert_allclose(np.diff(recording.time_s), STEP_S, atol=1e-6)
    np.testing.assert_allclose(recording.angle_deg, np.degrees(POSITION), atol=1e-4)
    seen = recording.command_at(recording.time_s + 1e-4)
    np.testing.assert_allclose(seen, np.degrees(GOAL), atol=1e-4)


# --- JSON -----------------------------------------------------------------------------------------


def nested() -> list[dict[str, Any]]:
    rows = zip(TIMES, GOAL, POSITION, strict=True)
    return [{"t": 1e3 * t, "arm": {"goal": u}, "pos": [0.0, y]} for t, u, y in rows]


MAP = columns("time=t:ms", "command=arm.goal:rad", "angle=pos[1]:rad")


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(nested()),
        json.dumps({"servo": "x", "samples": nested()}),
        "\n".join(map(json.dumps, nested())),
    ],
    ids=["list", "object", "lines"],
)
def test_json_of_records(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.log"
    path.write_text(text)
    recording = import_recording(path, MAP)
    is_sound(recording)
    assert recording.details["source"]["angle_column"] == "pos[1]"


def test_json_of_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"time_s": TIMES, "command (rad)": GOAL, "angle_rad": POSITION}))
    is_sound(import_recording(path, Request()))
    is_sound(read(path))


@pytest.mark.parametrize(
    ("records", "words"),
    [
        ([*nested()[:7], {"t": 1}, *nested()[8:]], ("record 7", "arm.goal")),
        ([*nested()[:7], "x", *nested()[8:]], ("record 7", "no number")),
        ([], ("no records",)),
        ([1, 2], ("no records",)),
    ],
)
def test_json_with_a_fault(tmp_path: Path, records: Any, words: tuple[str, ...]) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(records))
    refused(path, MAP, *words)


def test_json_columns_with_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    table = {"time_s": TIMES, "command_rad": GOAL, "angle_rad": [*POSITION[:-1], "x"]}
    path.write_text(json.dumps(table))
    refused(path, Request(), "value 199", "angle_rad", "'x'")
    path.write_text(json.dumps(table | {"angle_rad": POSITION[:-1]}))
    refused(path, Request(), "199 values", "200")
    path.write_text('[{"t": 1}, {')
    refused(path, Request(), "is no JSON")
    path.write_text("[" * 100_000)
    refused(path, Request(), "JSON")


# --- Parquet and LeRobot --------------------------------------------------------------------------


def parquet(path: Path, **more: Any) -> Path:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    stamps = pa.array([round(1e9 * t) for t in TIMES], type=pa.timestamp("ns"))
    table = {"stamp": stamps, "goal (rad)": GOAL, "state": [[0.0, y] for y in POSITION]}
    pq.write_table(pa.table(table | more), str(path))
    return path


PARQUET_MAP = columns("time=stamp", "command=goal", "angle=state[1]:rad")


def test_parquet(tmp_path: Path) -> None:
    path = parquet(tmp_path / "a.bin")
    is_sound(import_recording(path, PARQUET_MAP))
    refused(
        path, columns("time=stamp", "command=goal", "angle=x:rad"), "no column x", "state[0..1]"
    )
    refused(path, Request(), "time", "--map time=COLUMN", "stamp, goal (rad), state[0..1]")


def test_parquet_without_torque_at_the_end(tmp_path: Path) -> None:
    path = parquet(tmp_path / "a.bin", torque_enable=[n < 150 for n in range(COUNT)])
    recording = import_recording(path, PARQUET_MAP)
    assert recording.time_s.size == 150
    assert "torque_enable is false in 50 of 200 rows" in recording.notes[0]


@pytest.mark.parametrize("text", [True, False], ids=["records", "columns"])
def test_json_without_torque_at_the_end(tmp_path: Path, text: bool) -> None:
    on = [n < 150 for n in range(COUNT)]
    content: Any = {"time_s": TIMES, "command_rad": GOAL, "angle_rad": POSITION, "TorqueEnable": on}
    if text:
        rows = zip(*content.values(), strict=True)
        content = [dict(zip(content, row, strict=True)) for row in rows]
    (tmp_path / "a.json").write_text(json.dumps(content))
    recording = import_recording(tmp_path / "a.json", Request())
    assert recording.time_s.size == 150
    assert "TorqueEnable is false in 50 of 200" in recording.notes[0]


def lerobot(folder: Path, episodes: int = 2, per_file: int = 2) -> Path:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    joint = {"dtype": "float32", "shape": [2], "names": ["pan", "elbow"]}
    features = {
        "action": joint,
        "observation.state": joint | {"names": {"motors": ["pan", "elbow"]}},
        "observation.images.top": {"dtype": "video", "shape": [480, 640, 3], "names": None},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
    }
    (folder / "meta").mkdir(parents=True)
    info = {"codebase_version": "v3.0", "fps": 100, "features": features}
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    rows = [
        {
            "action": [0.0, u * (1 + episode)],
            "observation.state": [0.0, y * (1 + episode)],
            "timestamp": t,
            "episode_index": episode,
        }
        for episode in range(episodes)
        for t, u, y in zip(TIMES, GOAL, POSITION, strict=True)
    ]
    (folder / "data" / "chunk-000").mkdir(parents=True)
    for number in range(0, episodes, per_file):
        part = [row for row in rows if number <= row["episode_index"] < number + per_file]
        file = folder / "data" / "chunk-000" / f"file-{number:03d}.parquet"
        pq.write_table(pa.Table.from_pylist(part), str(file))
    return folder


JOINT_WORDS = ("command=action[elbow]:rad", "angle=observation.state[1]:rad")
JOINT = columns(*JOINT_WORDS)


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
    """``--unit`` holds for it; without any, degrees are assumed, which a note says."""
    folder = MAKERS[kind](tmp_path / "set")
    words = {
        "lerobot": ("command=action[elbow]", "angle=observation.state[elbow]"),
        "rosbag": ("command=/goal.position[elbow]", "angle=/joint_states.position[elbow]"),
    }[kind]
    is_sound(import_recording(folder, replace(columns(*words), unit="rad")))
    silent = import_recording(folder, columns(*words))
    assert any("no unit is given for" in note for note in silent.notes)


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


# --- logs of messages -----------------------------------------------------------------------------


def ulog(path: Path, on: int = COUNT) -> Path:
    """Two topics by the format's own rules; the second instance of a topic is another servo.

    Its motor has torque in the first ``on`` samples.
    """

    def message(kind: str, data: bytes) -> bytes:
        return struct.pack("<HB", len(data), ord(kind)) + data

    parts = [
        b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0),
        message("B", bytes(40)),
        message("F", b"servo_setpoint:uint64_t timestamp;float[2] position;"),
        message(
            "F",
            b"servo_status:uint64_t timestamp;float position;float load_torque;bool torque_enable;",
        ),
        message("A", struct.pack("<BH", 0, 0) + b"servo_setpoint"),
        message("A", struct.pack("<BH", 1, 1) + b"servo_status"),
    ]
    for n, (t, u, y) in enumerate(zip(TIMES, GOAL, POSITION, strict=True)):
        stamp = round(1e6 * t)
        parts.append(message("D", struct.pack("<HQff", 0, stamp, 0.0, u)))
        parts.append(message("D", struct.pack("<HQff?", 1, stamp, y, 0.3, n < on)))
    path.write_bytes(b"".join(parts))
    return path


def test_px4_logs(tmp_path: Path) -> None:
    pytest.importorskip("pyulog")
    path = ulog(tmp_path / "flight")
    words = ("command=servo_setpoint.position[1]:rad", "angle=servo_status[1].position:rad")
    is_sound(import_recording(path, columns(*words)))
    (note,) = import_recording(path, columns(*words)).notes
    assert "column servo_status.load_torque is not used" in note
    refused(path, Request(), "--map command=COLUMN:UNIT", "servo_setpoint.position[0..1]")
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


def bag(folder: Path, storage: str) -> Path:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    joint, header, stamp = (
        store.types[name]
        for name in (
            "sensor_msgs/msg/JointState",
            "std_msgs/msg/Header",
            "builtin_interfaces/msg/Time",
        )
    )
    empty = np.array([], dtype=np.float64)
    with Writer(folder, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        wrench, vector = (
            store.types[f"geometry_msgs/msg/{name}"] for name in ("WrenchStamped", "Vector3")
        )
        load = writer.add_connection("/load", wrench.__msgtype__, typestore=store)
        inner, zero = store.types["geometry_msgs/msg/Wrench"], vector(x=0.0, y=0.0, z=0.0)
        still = wrench(
            header=header(stamp=stamp(sec=1, nanosec=0), frame_id=""),
            wrench=inner(force=vector(x=2.0, y=0.0, z=0.0), torque=zero),
        )
        start = 1_700_000_000_000_000_000
        writer.write(load, start, store.serialize_cdr(still, wrench.__msgtype__))
        topics = {
            name: writer.add_connection(name, joint.__msgtype__, typestore=store)
            for name in ("/goal", "/joint_states")
        }
        for t, u, y in zip(TIMES, GOAL, POSITION, strict=True):
            at = 1_700_000_000_000_000_000 + round(1e9 * t)
            for late, (name, value) in enumerate((("/goal", u), ("/joint_states", y))):
                message = joint(
                    header=header(stamp=stamp(sec=at // 10**9, nanosec=at % 10**9), frame_id=""),
                    name=["pan", "elbow"],
                    position=np.array([0.0, value]),
                    velocity=empty,
                    effort=empty,
                )
                data = store.serialize_cdr(message, joint.__msgtype__)
                writer.write(topics[name], at + 3_000_000 * late, data)
    return folder


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


# --- recognising ----------------------------------------------------------------------------------

MAKERS: dict[str, Callable[[Path], Path]] = {
    "parquet": parquet,
    "ulog": ulog,
    "lerobot": lerobot,
    "rosbag": lambda path: bag(path, "MCAP"),
}


@pytest.mark.parametrize("name", MAKERS)
def test_formats_are_recognised_whatever_their_name(tmp_path: Path, name: str) -> None:
    path = MAKERS[name](tmp_path / "a.csv")
    found = recognised(path)
    assert found is not None
    assert found.name == name


def test_what_nobody_recognises(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"\0\1\2" * 50)
    refused(tmp_path / "a.csv", Request(), "binary file of no known format", "CSV")
    (tmp_path / "empty").mkdir()
    refused(tmp_path / "empty", Request(), "folder of no known format")


@pytest.mark.parametrize("name", ["parquet", "ulog", "lerobot", "rosbag"])
def test_a_missing_library_is_named(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = MAKERS[name](tmp_path / "a")
    monkeypatch.setattr(apart, "find_spec", lambda library: None)
    request = JOINT if name == "lerobot" else PARQUET_MAP
    if name in ("ulog", "rosbag"):
        request = columns("command=x:rad", "angle=y:rad")
    refused(path, request, "pip install 'servosight[logs]'")


@pytest.mark.parametrize("name", ["parquet", "ulog", "rosbag"])
def test_half_a_file_is_refused(tmp_path: Path, name: str) -> None:
    path = MAKERS[name](tmp_path / "a")
    file = path if path.is_file() else next(path.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 20])
    if path.is_dir():
        shutil.copy(file, tmp_path / "half.mcap")
        path = tmp_path / "half.mcap"
    request = PARQUET_MAP
    if name in ("ulog", "rosbag"):
        request = columns("command=x:rad", "angle=y:rad")
    refused(path, request)
