"""JSON of any program: a list of records, an object of columns, or a record in each line."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import LARGEST_LOG, Array, InputError, Recording, read_text
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, raw_columns, source_of
from servosight.models.io.importers._request import Request

_KIND = "a log in JSON: a list of records, columns of equal length, or a record in each line"
_DEEPEST = 4


def recognises(path: Path, start: bytes) -> bool:
    """What begins as an object or a list."""
    return start.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] in (b"{", b"[")


def read_json_log(path: Path, request: Request) -> Recording:
    """Read a log; the name of a nested number is its path, as in ``state.pos`` and ``pos[0]``."""
    records, columns = _content(path)
    if columns is not None:
        names, word = list(columns), "value"
    else:
        names, word = list(dict(_numbers(records[0]))), "record"

    def numbers(name: str) -> Array:
        values = columns[name] if columns is not None else _along(path, records, name)
        return _as_array(path, name, values)

    table = Columns(str(path), names, numbers, range, word)
    raw, notes = raw_columns(path, table, request)
    return assemble(path, raw, request, {"source": source_of(path, "json", raw)}, notes)


def _content(path: Path) -> tuple[list[Any], dict[str, list[Any]] | None]:
    """Records, or the columns of an object that has them."""
    text = read_text(path, _KIND, LARGEST_LOG)
    try:
        found = json.loads(text)
    except RecursionError:
        raise InputError(f"{path}: is nested too deep, expected {_KIND}; check the name") from None
    except ValueError as error:
        found = _lines(path, text, error)
    if isinstance(found, Mapping):
        lists = {name: one for name, one in found.items() if isinstance(one, list) and one}
        flat = {name: one for name, one in lists.items() if not isinstance(one[0], list | Mapping)}
        if flat:
            return [], flat
        found = max(lists.values(), key=len, default=[])
    if not isinstance(found, list) or not found or not isinstance(found[0], Mapping):
        raise InputError(f"{path}: holds no records and no columns, expected {_KIND}; convert it")
    return found, None


def _lines(path: Path, text: str, error: ValueError) -> list[Any]:
    rows = [line for line in text.splitlines() if line.strip()]
    try:
        return [json.loads(line) for line in rows] if len(rows) > 1 else _no_json(path, error)
    except (ValueError, RecursionError):
        return _no_json(path, error)


def _no_json(path: Path, error: ValueError) -> list[Any]:
    why = " ".join(str(error).split())[:100]
    raise InputError(f"{path}: is no JSON ({why}), expected {_KIND}; correct that place") from None


def _numbers(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Names and values of the numbers in a record; true and false count as 1 and 0."""
    if isinstance(value, Mapping) and depth < _DEEPEST:
        for key, inner in value.items():
            yield from _numbers(inner, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(value, list) and depth < _DEEPEST:
        for place, inner in enumerate(value[:100]):
            yield from _numbers(inner, f"{name}[{place}]", depth + 1)
    elif isinstance(value, int | float):
        yield name, value


def _along(path: Path, records: Sequence[Any], name: str) -> list[Any]:
    """A number of each record."""
    values = []
    for place, record in enumerate(records):
        if isinstance(record, Mapping) and name in record:
            values.append(record[name])
            continue
        found = dict(_numbers(record))
        if name not in found:
            raise InputError(
                f"{path}, record {place}: has no number {name}, expected one in every record; "
                f"correct or delete the record"
            )
        values.append(found[name])
    return values


def _as_array(path: Path, name: str, values: Sequence[Any]) -> Array:
    for place, value in enumerate(values):
        if not isinstance(value, int | float):
            raise InputError(
                f"{path}, value {place}: {name} is {str(value)[:40]!r}, expected a number; correct "
                f"or delete it"
            )
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        raise InputError(
            f"{path}: {name} holds a whole number beyond 1e308, expected smaller ones; correct it"
        ) from None
