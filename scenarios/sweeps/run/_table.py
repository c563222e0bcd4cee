"""Rows as a table with one type a column, whatever the part they stand in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

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
