"""PX4 flight logs (ULog), by pyulog: docs.px4.io/main/en/dev_log/ulog_file_format.html."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from servosight.models.core import Recording
from servosight.models.io.importers._apart import Extract, Parser
from servosight.models.io.importers._request import Request
from servosight.models.io.importers.formats._streams import read_streams

PARSER = Parser(__name__, "a PX4 log", "pyulog")


def recognises(path: Path, start: bytes) -> bool:
    """The bytes that begin such a log."""
    return start.startswith(b"ULog\x01\x12\x35")


def read_ulog(path: Path, request: Request) -> Recording:
    """Read two topics' fields; ``topic.field``, or ``topic[1].field`` of a second instance."""
    return read_streams(path, PARSER, "ulog", request)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """The wanted fields with their stamps; runs in a process of its own."""
    from pyulog import ULog

    topics = sorted({name.partition(".")[0].partition("[")[0] for name in wanted})
    columns, times_s = {}, {}
    names: list[str] = []
    for only in (topics, None):  # all topics, to list them, where one was not found
        names = []
        for topic in ULog(str(path), only).data_list:
            instance = f"[{topic.multi_id}]" if topic.multi_id else ""
            stamps = topic.data["timestamp"].astype(np.int64)
            for field, values in topic.data.items():
                name = f"{topic.name}{instance}.{field}"
                if field == "timestamp":
                    continue
                names.append(name)
                if name in wanted:
                    columns[name] = np.asarray(values, dtype=np.float64)
                    times_s[name] = stamps / 1e6
        if wanted and len(columns) == len(set(wanted)):
            break
    return Extract(columns, tuple(sorted(names)), times_s)
