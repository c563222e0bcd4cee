"""NumPy's ``.npz`` and ``.npy``: arrays by their names, columns and fields by their places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.io.importers._apart import Extract, Parser
from servosight.models.io.importers._apart import extract as extract_apart
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import Request

PARSER = Parser(__name__, "a NumPy file")
_MOST_PLACES = 100


def recognises(path: Path, start: bytes) -> bool:
    """The bytes that begin a ``.npy``, or an archive whose first member is one."""
    name = start[30 : 30 + int.from_bytes(start[26:28], "little")]
    return start.startswith(b"\x93NUMPY") or (
        start.startswith(b"PK\x03\x04") and name.endswith(b".npy")
    )


def read_numpy(path: Path, request: Request) -> Recording:
    """Read arrays of equal length; ``data[2]`` is a column of a table, from 0."""
    found = extract_apart(path, PARSER)
    table = Columns(str(path), found.names, lambda name: found.columns[name], range, "index")
    raw, notes = raw_columns(path, table, request)
    return assemble(path, raw, request, {"source": source_of(path, "numpy", raw)}, notes)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """All arrays of numbers; runs in a process of its own. Pickled objects are not read."""
    content = np.load(path, allow_pickle=False)
    arrays = {"": content} if isinstance(content, np.ndarray) else dict(content)
    columns = {
        name: column for key, value in arrays.items() for name, column in _columns(key, value)
    }
    return Extract(columns, tuple(columns))


def _columns(name: str, value: np.ndarray) -> Iterator[tuple[str, Array]]:
    if value.dtype.names:
        for field in value.dtype.names:
            yield from _columns(f"{name}.{field}" if name else field, value[field])
    elif value.dtype.kind in "mM":  # stamps with a type of their own are in seconds
        kind = "timedelta64[ns]" if value.dtype.kind == "m" else "datetime64[ns]"
        yield from _columns(name, value.astype(kind).astype(np.int64) / 1e9)
    elif value.dtype.kind in "biuf" and value.ndim == 1:
        yield name, value.astype(np.float64)
    elif value.dtype.kind in "biuf" and value.ndim == 2:
        for place in range(min(value.shape[1], _MOST_PLACES)):
            yield f"{name}[{place}]", value[:, place].astype(np.float64)
