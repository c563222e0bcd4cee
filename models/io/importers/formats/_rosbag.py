"""ROS 2 bags and MCAP files, by rosbags: numbers in messages such as JointState.

A bag is a folder with metadata.yaml, or a single .mcap or .db3 file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from servosight.models.core import InputError, Recording
from servosight.models.io._power import power_columns
from servosight.models.io.importers._apart import CUT_OFF, Extract, Parser
from servosight.models.io.importers._request import Request
from servosight.models.io.importers.formats._mcap_end import MAGIC, with_end
from servosight.models.io.importers.formats._streams import read_streams

PARSER = Parser(__name__, "a ROS 2 bag", "rosbags")
_ENDINGS = {MAGIC: ".mcap", b"SQLite format 3\0": ".db3"}
"""The bytes that begin a file of a bag, and its ending."""
_HEADER_BYTES = 64
_JOINT_TYPES = (
    "sensor_msgs/msg/JointState",
    "trajectory_msgs/msg/JointTrajectory",
    "trajectory_msgs/msg/JointTrajectoryPoint",
    "control_msgs/msg/JointTrajectoryControllerState",
)
"""Messages whose positions of joints that turn are in radians (their definitions, and REP 103)."""
_POSITION = re.compile(r".*\.positions?\[[^]]*\]")
_MOST_PLACES = 100
_DEEPEST = 4


def recognises(path: Path, start: bytes) -> bool:
    """A folder with a bag's metadata, or the bytes that begin an MCAP or an SQLite file."""
    return start.startswith(tuple(_ENDINGS)) or (
        path.is_dir() and (path / "metadata.yaml").is_file()
    )


def read_rosbag(path: Path, request: Request) -> Recording:
    """Read two fields; ``/topic.field``, and by a joint's name as ``/topic.position[elbow]``."""
    return read_streams(path, PARSER, "rosbag", request)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """The wanted fields, and whether motors had torque, with their stamps; in its own process.

    Stamps are those in the messages' headers where every wanted topic has them, else the times at
    which the messages were recorded: two clocks would shift the angle against the command.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with TemporaryDirectory() as folder:
        place, cut = _readable(path, Path(folder))
        with AnyReader([place], default_typestore=store) as bag:
            names, found = _messages(bag, wanted)
            units = _units(bag, names)
    if cut and not names:
        raise InputError("ends before its first message, expected a whole bag; copy it again")
    by_header = all(row[0] > 0 for name in wanted for row in found.get(name, ()))
    if by_header:  # what else has no such stamp is on another clock
        found = {name: own for name, own in found.items() if all(row[0] > 0 for row in own)}
    rows = [row for own in found.values() for row in own]
    start_ns = min((row[0 if by_header else 1] for row in rows), default=0)
    times_s = {
        name: np.array([(row[0 if by_header else 1] - start_ns) / 1e9 for row in own])
        for name, own in found.items()
    }
    columns = {name: np.array([row[2] for row in own]) for name, own in found.items()}
    clock = "header.stamp" if by_header else "time of recording"
    facts, notes = {"clock": clock}, (CUT_OFF,) if cut else ()
    return Extract(columns, tuple(names), times_s, facts, notes, units)


def _messages(
    bag: Any, wanted: Sequence[str]
) -> tuple[list[str], dict[str, list[tuple[int, int, float]]]]:
    """All columns' names; rows of header's stamp [ns], time of recording [ns] and value by name."""
    names = _names(bag)
    chosen = {*wanted, *power_columns(names)} if wanted else set()
    topics = {name: _topic(name, bag.topics) for name in chosen}
    found: dict[str, list[tuple[int, int, float]]] = {name: [] for name in chosen}
    connections = [one for one in bag.connections if one.topic in topics.values()]
    for connection, logged_ns, data in bag.messages(connections) if connections else ():
        message = bag.deserialize(data, connection.msgtype)
        numbers = dict(_numbers(message))
        for name, topic in topics.items():
            value = numbers.get(name.removeprefix(f"{topic}."))
            if topic == connection.topic and value is not None:
                found[name].append((_stamp_ns(message), logged_ns, value))
    return names, {name: rows for name, rows in found.items() if rows}


def _units(bag: Any, columns: Iterable[str]) -> dict[str, str]:
    """The unit of each of the columns whose message is defined in one."""
    types = {one.topic: one.msgtype for one in bag.connections}
    return {
        name: "rad"
        for name in columns
        if _POSITION.fullmatch(name) and types.get(_topic(name, types)) in _JOINT_TYPES
    }


def _readable(path: Path, folder: Path) -> tuple[Path, bool]:
    """A bag that rosbags can read, and whether it is what an interrupted recorder left.

    A file gets a name in ``folder`` with the ending by which rosbags knows its kind, and there an
    end where its own is missing.
    """
    if path.is_dir():
        return path, False
    with path.open("rb") as stream:
        start = stream.read(_HEADER_BYTES)
    ending = next(one for mark, one in _ENDINGS.items() if start.startswith(mark))
    place = folder / f"bag{ending}"
    if ending == ".mcap":
        _check_profile(start)
        if with_end(path, place):
            return place, True
    place.symlink_to(path.resolve())
    return place, False


def _check_profile(start: bytes) -> None:
    """InputError for an MCAP file of messages that are none of ROS 2; mcap.dev/spec, Header."""
    if len(start) < _HEADER_BYTES:
        return
    size = int.from_bytes(start[17:21], "little")
    profile = start[21 : 21 + min(size, 40)].decode("utf-8", "replace")
    if profile != "ros2":
        kind = f"with the profile {profile!r}" if profile else "without a profile"
        raise InputError(
            f"is an MCAP file {kind}, expected the messages of ROS 2 (profile 'ros2'); export its "
            f"command and angle as CSV files"
        )


def _topic(name: str, topics: Iterable[str]) -> str:
    """The longest topic that a column's name begins with."""
    return max((one for one in topics if name.startswith(f"{one}.")), key=len, default="")


def _names(bag: Any) -> list[str]:
    """The numbers in the first message of each topic."""
    found, seen = [], set()
    for connection in bag.connections:
        if connection.topic in seen:
            continue
        seen.add(connection.topic)
        for _, _, data in bag.messages([connection]):
            try:
                message = bag.deserialize(data, connection.msgtype)
            except Exception:  # a type that the bag does not describe
                break
            found += [f"{connection.topic}.{name}" for name, _ in _numbers(message)]
            break
    return found


def _stamp_ns(message: Any) -> int:
    """The stamp in a message's header [ns]; 0 where there is none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _numbers(message: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, float]]:
    """Names and values of the numbers in a message; list places by the joints' names."""
    labels = [str(one) for one in getattr(message, "name", ()) if isinstance(one, str)]
    for field in getattr(message, "__dataclass_fields__", ()):
        value = getattr(message, field)
        if field in ("header", "name", "__msgtype__"):
            continue
        if isinstance(value, bool | int | float | np.number):
            yield f"{prefix}{field}", float(value)
        elif isinstance(value, np.ndarray | list):
            for place, one in enumerate(value[:_MOST_PLACES]):
                name = labels[place] if len(labels) == len(value) else str(place)
                if isinstance(one, int | float | np.number):
                    yield f"{prefix}{field}[{name}]", float(one)
                elif depth < _DEEPEST:
                    yield from _numbers(one, f"{prefix}{field}[{name}].", depth + 1)
        elif depth < _DEEPEST:
            yield from _numbers(value, f"{prefix}{field}.", depth + 1)
