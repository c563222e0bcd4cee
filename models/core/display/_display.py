"""Tables of results as text, as HTML for a notebook and as a data frame."""

from __future__ import annotations

import html
import importlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from servosight.models.base import InputError
from servosight.models.core.display._rounding import rounded, uncertain

Rows = Sequence[Mapping[str, Any]]
DIGITS = 4


class Uncertain(Protocol):
    """A value with one standard deviation (None: not known) and a unit."""

    @property
    def value(self) -> float: ...
    @property
    def sigma(self) -> float | None: ...
    @property
    def unit(self) -> str: ...


def parameter_rows(parameters: Mapping[str, Uncertain | Sequence[Uncertain]]) -> Rows:
    """One row a parameter, its value rounded to its sigma; a list gets one row for each."""
    rows = []
    for name, entry in parameters.items():
        several = list(entry) if isinstance(entry, Sequence) else [entry]
        for number, one in enumerate(several, 1):
            value, sigma = uncertain(one.value, one.sigma)
            label = name if len(several) == 1 else f"{name} ({number})"
            unit = "" if one.unit == "-" else one.unit
            rows.append({"parameter": label, "value": value, "sigma": sigma, "unit": unit})
    return rows


def cell(value: Any) -> str:
    """A value as a table shows it."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return rounded(value, DIGITS)
    if isinstance(value, list | tuple):
        return ", ".join(map(cell, value))
    return str(value)


def columns(rows: Rows) -> list[str]:
    """The columns that a table shows: no nested tables."""
    names = dict.fromkeys(name for row in rows for name in row)
    return [name for name in names if not any(_nested(row.get(name)) for row in rows)]


def text_table(rows: Rows) -> str:
    """Aligned columns under their names."""
    names = columns(rows)
    lines = [names, *([cell(row.get(name)) for name in names] for row in rows)]
    widths = [max(len(line[place]) for line in lines) for place in range(len(names))]
    return "\n".join(
        "  ".join(word.ljust(width) for word, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def html_table(rows: Rows, caption: str = "") -> str:
    """A table for a notebook; everything in it is escaped."""
    names = columns(rows)
    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell(row.get(name)))}</td>" for name in names) + "</tr>"
        for row in rows
    )
    title = f"<caption>{html.escape(caption)}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def frame(rows: Rows) -> Any:
    """The rows as a pandas data frame or, without pandas, a Polars one; nested tables flattened.

    Raises InputError where neither is installed.
    """
    flat = [_flat(row) for row in rows]
    names = dict.fromkeys(name for row in flat for name in row)
    table = {name: [row.get(name) for row in flat] for name in names}
    for library in ("pandas", "polars"):
        try:
            module = importlib.import_module(library)
        except ImportError:
            continue
        return module.DataFrame(table)
    raise InputError(
        "to_frame: neither pandas nor Polars is installed, expected one of them; run "
        "`pip install pandas`"
    )


def _flat(row: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as columns with dots in their names."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        name = f"{prefix}{key}"
        flat |= _flat(value, f"{name}.") if isinstance(value, Mapping) else {name: value}
    return flat


def _nested(value: Any) -> bool:
    several = isinstance(value, list | tuple)
    return isinstance(value, Mapping) or (
        several and any(isinstance(item, Mapping | list | tuple) for item in value)
    )
