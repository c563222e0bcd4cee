"""One motion in the formats of other programs' logs."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.models.core import Recording
from servosight.models.io.importers import Request, parse_map

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


def nested() -> list[dict[str, Any]]:
    rows = zip(TIMES, GOAL, POSITION, strict=True)
    return [{"t": 1e3 * t, "arm": {"goal": u}, "pos": [0.0, y]} for t, u, y in rows]


MAP = columns("time=t:ms", "command=arm.goal:rad", "angle=pos[1]:rad")


def parquet(path: Path, **more: Any) -> Path:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    stamps = pa.array([round(1e9 * t) for t in TIMES], type=pa.timestamp("ns"))
    table = {"stamp": stamps, "goal (rad)": GOAL, "state": [[0.0, y] for y in POSITION]}
    pq.write_table(pa.table(table | more), str(path))
    return path


PARQUET_MAP = columns("time=stamp", "command=goal", "angle=state[1]:rad")


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


MAKERS: dict[str, Callable[[Path], Path]] = {
    "parquet": parquet,
    "ulog": ulog,
    "lerobot": lerobot,
    "rosbag": lambda path: bag(path, "MCAP"),
}
