"""Rows as a table with one type a column, whatever the part they stand in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import InputError

if TYPE_CHECKING:
    import polars as pl

KEY = "cell"
TEXTS = (KEY, "made", "status", "error", "verdict", "versions")
WHOLE = ("seed", "scenario_seed", "samples")
_TRUTHS = ("named",)
_LISTS = ("effects",)


def frame_of(rows: Sequence[Mapping[str, Any]]) -> pl.DataFrame:
    """The rows as a Polars frame; numbers are 64-bit floats but for the columns of ``WHOLE``."""
    import polars as pl

    names = dict.fromkeys(name for row in rows for name in row)
    columns = []
    for name in names:
        values = [row.get(name) for row in rows]
        kind = _type(name, values)
        if kind == pl.Float64:
            values = [None if value is None else float(value) for value in values]
        columns.append(pl.Series(name, values, kind))
    return pl.DataFrame(columns)


def read_part(path: Path, columns: Sequence[str] | None = None) -> pl.DataFrame:
    """The rows of a Parquet file, ``columns`` of them; InputError where it is damaged."""
    import polars as pl

    damaged = InputError(
        f"{path}: is no whole Parquet file with the columns {KEY} and status, expected a part that "
        f"`servosight sweep` wrote; remove it and run the sweep again, which runs its cells anew"
    )
    try:
        types = pl.read_parquet_schema(path)
        if types.get(KEY) != pl.String or types.get("status") != pl.String:
            raise damaged
        return pl.read_parquet(path, columns=None if columns is None else list(columns))
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError):
        raise damaged from None


def joined(frames: Iterable[pl.DataFrame]) -> pl.DataFrame:
    """Frames below one another; a column that one lacks is empty there."""
    import polars as pl

    return pl.concat(list(frames), how="diagonal_relaxed")


def _type(name: str, values: Sequence[Any]) -> Any:
    import polars as pl

    if name in TEXTS:
        return pl.String
    if name in WHOLE:
        return pl.Int64
    if name in _TRUTHS:
        return pl.Boolean
    if name in _LISTS:
        return pl.List(pl.String)
    first = next((value for value in values if value is not None), None)
    if isinstance(first, bool):
        return pl.Boolean
    if isinstance(first, str):
        return pl.String
    if isinstance(first, int | float) or first is None:
        return pl.Float64
    return None
