"""Small valid logs of other programs: JSON, Parquet, LeRobot, PX4 ULog, MCAP."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path

Rows = Sequence[tuple[float, float, float]]


def write_logs(folder: Path, rows: Rows) -> None:
    """Write one of each into ``folder``; ``rows`` of time [s], command and angle [deg]."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    t, u, y = map(list, zip(*rows, strict=True))
    table = {"time_s": t, "command_deg": u, "angle_deg": y}
    (folder / "log.json").write_text(json.dumps(table))
    pq.write_table(pa.table(table), str(folder / "log.parquet"))
    _write_data_set(folder / "set", rows)
    _write_ulog(folder / "log.ulg", rows)
    _write_mcap(folder, rows)


def _write_data_set(folder: Path, rows: Rows) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    feature = {"dtype": "float32", "shape": [2], "names": ["pan", "elbow"]}
    features = {
        "action": feature,
        "state": feature,
        "timestamp": {"dtype": "float32", "shape": [1]},
    }
    for place in ("meta", "data"):
        (folder / place).mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps({"fps": 50, "features": features}))
    frames = [
        {"action": [0.0, u], "state": [0.0, y], "timestamp": t, "episode_index": 0}
        for t, u, y in rows
    ]
    pq.write_table(pa.Table.from_pylist(frames), str(folder / "data" / "a.parquet"))


def _write_ulog(path: Path, rows: Rows) -> None:
    def message(kind: str, data: bytes) -> bytes:
        return struct.pack("<HB", len(data), ord(kind)) + data

    parts = [b"ULog\x01\x12\x35\x01", bytes(8), message("B", bytes(40))]
    names = (b"goal", b"angle")
    parts += [message("F", name + b":uint64_t timestamp;float data;") for name in names]
    parts += [message("A", struct.pack("<BH", 0, n) + name) for n, name in enumerate(names)]
    for t, *values in rows:
        for n, value in enumerate(values):
            parts.append(message("D", struct.pack("<HQf", n, round(1e6 * t), value)))
    path.write_bytes(b"".join(parts))


def _write_mcap(folder: Path, rows: Rows) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    number = store.types["std_msgs/msg/Float64"]
    bag = folder / "bag"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = [
            writer.add_connection(name, number.__msgtype__, typestore=store)
            for name in ("goal", "angle")
        ]
        for t, *values in rows:
            for topic, value in zip(topics, values, strict=True):
                data = store.serialize_cdr(number(data=value), number.__msgtype__)
                writer.write(topic, round(1e9 * t), data)
    (bag / "bag.mcap").rename(folder / "log.mcap")
    (bag / "metadata.yaml").unlink()
    bag.rmdir()
