"""JSON of any program: a list of records, an object of columns, or a record in each line."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import LARGEST_LOG, Array, InputError, Recording
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import Request
from servosight.models.io.tables import date_kind, log_text, seconds_of

_KIND = "a log in JSON: a list of records, columns of equal length, or a record in each line"
_DEEPEST = 4
_MOST_PLACES = 100


def recognises(path: Path, start: bytes) -> bool:
    """What begins as an object or a list."""
    return start.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] in (b"{", b"[")


def read_json_log(path: Path, request: Request) -> Recording:
    """Read a log; the name of a nested number is its path, as in ``state.pos`` and ``pos[0]``."""
    columns, word = _columns(path)
    kinds = {name: _date_kind(values) for name, values in columns.items()}
    dated = {name: kind for name, kind in kinds.items() if kind is not None}

    def numbers(name: str) -> Array:
        if name in dated:
            cells = ["" if one is None else str(one) for one in columns[name]]
            return seconds_of(path, name, cells, range(len(cells)))
        return _as_array(path, name, columns[name], word)

    names = [name for name in columns if name in dated or any(map(_is_number, columns[name]))]
    table = Columns(str(path), names, numbers, range, word, dated=dated)
    raw, notes = raw_columns(path, table, request)
    return assemble(path, raw, request, {"source": source_of(path, "json", raw)}, notes)


def _columns(path: Path) -> tuple[dict[str, list[Any]], str]:
    """The values by column, None where a record has none, and what one of them is called."""
    text = log_text(path, _KIND, LARGEST_LOG)
    try:
        content = json.loads(text)
    except RecursionError:
        raise InputError(f"{path}: is nested too deep, expected {_KIND}; check the name") from None
    except ValueError as error:
        content = _lines(path, text, error)
    lists = dict(_lists(content))
    records = max(lists.values(), key=_records, default=[])
    flat = {name: one for name, one in lists.items() if name and not _records(one)}
    if flat and max(map(len, flat.values())) >= _records(records):
        return flat, "value"
    if not _records(records):
        raise InputError(f"{path}: holds no records and no columns, expected {_KIND}; convert it")
    return _of_records(path, records), "record"


def _lists(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, list[Any]]]:
    """All lists by their paths; an object whose keys count from 0 is one, as pandas writes it."""
    if isinstance(value, Mapping) and value and all(map(str.isdigit, value)):
        value = list(value.values())
    if isinstance(value, list) and value:
        yield name, value
    elif isinstance(value, Mapping) and depth < _DEEPEST:
        for key, inner in value.items():
            yield from _lists(inner, f"{name}.{key}" if name else str(key), depth + 1)


def _records(values: Sequence[Any]) -> int:
    """How many records a list holds; 0 where it holds none."""
    return len(values) if values and isinstance(values[0], list | Mapping) else 0


def _of_records(path: Path, records: Sequence[Any]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for place, record in enumerate(records):
        if not isinstance(record, list | Mapping):
            raise InputError(
                f"{path}, record {place}: is {str(record)[:40]!r}, expected an object with "
                f"numbers, as in the record before; correct or delete it"
            )
        for name, value in _values(record):
            if name not in found:
                found[name] = [None] * len(records)
            found[name][place] = value
    return found


def _lines(path: Path, text: str, error: ValueError) -> list[Any]:
    """A record in each line; InputError with the line that is none."""
    rows = [(number, row) for number, row in enumerate(text.splitlines(), 1) if row.strip()]
    found = []
    for number, row in rows:
        try:
            found.append(json.loads(row))
        except (ValueError, RecursionError) as wrong:
            # Where not even the first line is a record, the file was meant as one piece of JSON.
            why = " ".join(str(wrong if found else error).split())[:100]
            where = f", row {number}" if found else ""
            raise InputError(
                f"{path}{where}: is no JSON ({why}), expected {_KIND}; correct that place"
            ) from None
    return found


def _values(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Names and values of what is single in a record."""
    if isinstance(value, Mapping) and depth < _DEEPEST:
        for key, inner in value.items():
            yield from _values(inner, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(value, list) and depth < _DEEPEST:
        for place, inner in enumerate(value[:_MOST_PLACES]):
            yield from _values(inner, f"{name}[{place}]", depth + 1)
    elif not isinstance(value, list | Mapping):
        yield name, value


def _date_kind(values: Sequence[Any]) -> str | None:
    first = next((one for one in values if one is not None), None)
    return date_kind(first) if isinstance(first, str) else None


def _is_number(value: Any) -> bool:
    """True also for text that is a number; true and false count as 1 and 0."""
    if not isinstance(value, str):
        return isinstance(value, int | float)
    try:
        float(value)
    except ValueError:
        return False
    return True


def _as_array(path: Path, name: str, values: Sequence[Any], word: str) -> Array:
    for place, value in enumerate(values):
        if value is not None and not _is_number(value):
            raise InputError(
                f"{path}, {word} {place}: {name} is {str(value)[:40]!r}, expected a number; "
                f"correct or delete it"
            )
    try:
        return np.array([np.nan if one is None else float(one) for one in values])
    except OverflowError:
        raise InputError(
            f"{path}: {name} holds a whole number beyond 1e308, expected smaller ones; correct it"
        ) from None
