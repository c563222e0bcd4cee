"""Parquet tables, by pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.io._power import power_columns
from servosight.models.io.importers._apart import Extract, Parser
from servosight.models.io.importers._apart import extract as extract_apart
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import (
    Columns,
    chosen_columns,
    raw_columns,
    source_of,
)
from servosight.models.io.importers._request import Request

PARSER = Parser(__name__, "a Parquet file", "pyarrow")
_SMALL = 2_000_000
"""Numbers of a table that is read whole, which saves a second process."""


def recognises(path: Path, start: bytes) -> bool:
    """The four bytes that begin and end such a file."""
    return start.startswith(b"PAR1")


def read_parquet(path: Path, request: Request) -> Recording:
    """Read a table; a column of lists is one of numbers for each place, as in ``state[2]``."""
    found = extract_apart(path, PARSER)
    table = Columns(str(path), found.names, lambda name: found.columns[name], range)
    wanted = {column.name for column in chosen_columns(path, table, request).values()}
    if not wanted <= set(found.columns):  # a large table
        found = extract_apart(path, PARSER, sorted({*wanted, *power_columns(found.names)}))
    raw, notes = raw_columns(path, table, request)
    return assemble(path, raw, request, {"source": source_of(path, "parquet", raw)}, notes)


def extract(path: Path, wanted: Sequence[str]) -> Extract:
    """The wanted columns, all of a small table where none is named; in a process of its own."""
    import pyarrow.parquet as pq

    file = pq.ParquetFile(str(path))
    names = number_columns(file.schema_arrow, lambda name: _first(file, name))
    if not wanted and len(names) * file.metadata.num_rows <= _SMALL:
        wanted = names
    table = file.read(columns=whole_columns(wanted, file.schema_arrow.names))
    return Extract({name: numbers(table, name) for name in wanted}, names)


def number_columns(schema: Any, first: Any) -> tuple[str, ...]:
    """Names of the columns of numbers; ``first(name)`` gives the first value of one of lists."""
    import pyarrow.types as kinds

    found: list[str] = []
    for one in schema:
        kind = one.type
        if kinds.is_list(kind) or kinds.is_large_list(kind) or kinds.is_fixed_size_list(kind):
            if _is_number(kind.value_type):
                found += [f"{one.name}[{place}]" for place in range(len(first(one.name) or ()))]
        elif _is_number(kind):
            found.append(one.name)
    return tuple(found)


def numbers(table: Any, name: str) -> Array:
    """A column of a table, or one place of a column of lists, (rows,); NaN where there is none.

    Stamps with a type of their own are in seconds.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    column, place = name, None
    if name not in table.column_names:
        column, _, rest = name.rpartition("[")
        place = int(rest.rstrip("]"))
    values = table.column(column)
    if place is not None:
        values = pc.list_element(values, place)
    per_s = 1.0
    for is_time, in_ns in (
        (pa.types.is_timestamp, pa.timestamp("ns")),
        (pa.types.is_duration, pa.duration("ns")),
    ):
        if is_time(values.type):
            values, per_s = pc.cast(pc.cast(values, in_ns, safe=False), pa.int64()), 1e9
    if pa.types.is_boolean(values.type):
        values = pc.cast(values, pa.int8())
    values = pc.cast(values, pa.float64(), safe=False)
    return np.asarray(values.to_numpy(zero_copy_only=False), dtype=np.float64) / per_s


def whole_columns(wanted: Sequence[str], names: Sequence[str]) -> list[str]:
    """The table's columns in which the wanted ones are."""
    return sorted({name if name in names else name.rpartition("[")[0] for name in wanted})


def _is_number(kind: Any) -> bool:
    import pyarrow.types as kinds

    times = (kinds.is_timestamp, kinds.is_duration)
    tests = (kinds.is_integer, kinds.is_floating, kinds.is_boolean, *times)
    return any(test(kind) for test in tests)


def _first(file: Any, name: str) -> Any:
    for batch in file.iter_batches(batch_size=1, columns=[name]):
        return batch.column(0)[0].as_py()
    return None
