"""PX4 flight logs (ULog), by pyulog: docs.px4.io/main/en/dev_log/ulog_file_format.html."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.io._power import power_columns
from servosight.models.io.importers._apart import CUT_OFF, Extract, Parser
from servosight.models.io.importers._request import Request
from servosight.models.io.importers.formats._streams import read_streams

PARSER = Parser(__name__, "a PX4 log", "pyulog")
_HEAD = 3


def recognises(path: Path, start: bytes) -> bool:
    """The bytes that begin such a log."""
    return start.startswith(b"ULog\x01\x12\x35")


def read_ulog(path: Path, request: Request) -> Recording:
    """Read two topics' fields; ``topic.field``, or ``topic[1].field`` of a second instance."""
    return read_streams(path, PARSER, "ulog", request)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """The wanted fields, and whether motors had torque, with their stamps; in its own process."""
    from pyulog import ULog

    formats = ULog(str(path), parse_header_only=True).message_formats
    names = [f"{topic}.{field}" for topic in formats for field in _fields(formats, topic)]
    chosen = {*wanted, *power_columns(names)}
    topics = sorted({name.partition(".")[0].partition("[")[0] for name in chosen})
    file = _File(path)
    columns, times_s = _data(ULog(file, topics), wanted)
    if not wanted or not set(wanted) <= set(columns):  # all that is there, to list it
        log = ULog(str(path))
        names = [name for topic in log.data_list for name in _topic_names(topic)]
    return Extract(columns, tuple(sorted(names)), times_s, notes=(CUT_OFF,) if file.cut else ())


class _File(io.BufferedReader):
    """A log that knows whether its end cut a message off: pyulog stops there and says nothing.

    pyulog reads the head of each message, its size in two bytes and its kind, and then the message.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self.cut = False
        self._message: int | None = None

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        if self._message is not None and size == self._message:
            self.cut |= len(data) < self._message
            self._message = None
        elif size == _HEAD:
            self.cut |= 0 < len(data) < _HEAD
            self._message = int.from_bytes(data[:2], "little") if len(data) == _HEAD else None
        return data


def _data(log: Any, wanted: Sequence[str]) -> tuple[dict[str, Array], dict[str, Array]]:
    """The wanted columns of a log, those on torque, and their stamps [s]."""
    columns, times_s = {}, {}
    for topic in log.data_list:
        for name, field in _topic_names(topic).items():
            if name in wanted or power_columns([name]):
                columns[name] = np.asarray(topic.data[field], dtype=np.float64)
                times_s[name] = topic.data["timestamp"].astype(np.int64) / 1e6
    return columns, times_s


def _topic_names(topic: Any) -> dict[str, str]:
    """The fields of one instance of a topic by their names."""
    instance = f"[{topic.multi_id}]" if topic.multi_id else ""
    return {
        f"{topic.name}{instance}.{field}": field for field in topic.data if field != "timestamp"
    }


def _fields(formats: Mapping[str, Any], kind: str) -> Iterator[str]:
    """The fields of a message as its format declares them."""
    for inner, size, name in formats[kind].fields:
        if name == "timestamp" or name.startswith("_padding"):
            continue
        for place in [f"{name}[{n}]" for n in range(size)] or [name]:
            if inner in formats:
                yield from (f"{place}.{field}" for field in _fields(formats, inner))
            else:
                yield place
