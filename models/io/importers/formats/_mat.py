"""MATLAB files: the EMPS benchmark as it stands, others by a map of their columns.

EMPS (electro-mechanical positioning system): Janot, Gautier, Brunot, "Data set and reference
models of EMPS", 2019. ``t`` [s], ``qg`` reference [m], ``qm`` measured position [m].
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.io.importers._apart import Extract, Parser
from servosight.models.io.importers._apart import extract as extract_apart
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import Column, Request

EMPS = {
    "time": Column("t", "s"),
    "command": Column("qg", "m"),
    "angle": Column("qm", "m"),
    "disturbance": Column("pulses_N", "N"),
}
"""The benchmark's variables; in the second of its files there is a force on the axis."""
EMPS_SCALE = 100.0
"""Degrees that show one metre: a centimetre of the axis reads as a degree."""
PARSER = Parser(
    __name__,
    "a MATLAB file",
    fix="expected a whole file of version 7.2 or older, so save it with -v7",
)


_DEEPEST = 6
_MOST_PLACES = 100


def recognises(path: Path, start: bytes) -> bool:
    """The text that MATLAB begins a file with, or the first header of a file of version 4."""
    if start.startswith(b"MATLAB ") or len(start) < 20:
        return start.startswith(b"MATLAB ")
    kind, rows, columns, imaginary, length = struct.unpack("<5i", start[:20])
    small = kind in range(52) and imaginary in (0, 1) and 1 < length < 65
    return small and rows >= 0 and columns >= 0 and start[19 + length : 20 + length] == b"\0"


def read_mat(path: Path, request: Request) -> Recording:
    """Read vectors of a MATLAB file (up to version 7.2)."""
    found = extract_apart(path, PARSER)
    known = {name: one for name, one in EMPS.items() if one.name in found.columns}
    request = replace(request, columns={**known, **request.columns})
    if request.unit_scale is None and any(one.unit == "m" for one in request.columns.values()):
        request = replace(request, unit_scale=EMPS_SCALE)
    table = Columns(
        str(path),
        found.names,
        lambda name: found.columns[name],
        lambda size: range(1, size + 1),
        "sample",
    )
    raw, notes = raw_columns(path, table, request)
    source = {**found.facts, **source_of(path, "mat", raw)}
    return assemble(path, raw, request, {"source": source}, notes)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """All vectors, in structs too, and all single numbers as facts; in a process of its own."""
    from scipy.io import loadmat

    content = {
        name: value
        for key, variable in loadmat(str(path), appendmat=False).items()
        for name, value in _arrays(key, variable)
    }
    vectors = {
        name: value.ravel().astype(np.float64)
        for name, value in content.items()
        if value.size > 1 and max(value.shape) == value.size
    }
    facts = {
        name: float(value.ravel()[0])
        for name, value in content.items()
        if value.size == 1 and "." not in name and np.isfinite(value.ravel()[0])
    }
    return Extract(vectors, tuple(vectors), facts=facts)


def _arrays(name: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Array]]:
    """A variable's arrays of numbers; those of a struct by MATLAB's names, as ``out.signals.y``."""
    if not isinstance(value, np.ndarray) or depth > _DEEPEST:
        return
    if value.dtype.names and value.size > 1 and _holds_samples(value):
        for field in value.dtype.names:
            yield f"{name}.{field}", np.array([one.item() for one in value[field].ravel()])
    elif value.dtype.names:
        for place, struct in enumerate(value.ravel()[:_MOST_PLACES], 1):
            which = f"{name}({place})" if value.size > 1 else name
            for field in value.dtype.names:
                yield from _arrays(f"{which}.{field}", struct[field], depth + 1)
    elif value.dtype.kind in "biuf" and value.ndim == 2 and min(value.shape) > 1:
        for place in range(min(value.shape[1], _MOST_PLACES)):
            yield f"{name}[{place + 1}]", value[:, place]
    elif value.dtype.kind in "biuf":
        yield name, value


def _holds_samples(structs: np.ndarray) -> bool:
    """True for an array of structs that is a record of single numbers for each sample."""
    cells = [one for field in structs.dtype.names or () for one in structs[field].ravel()]
    return all(
        isinstance(one, np.ndarray) and one.size == 1 and one.dtype.kind in "biuf" for one in cells
    )
