"""Strict reading of a TOML table into a frozen dataclass of numbers, words and switches."""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, TypeVar

from servosight.models.core import InputError

Settings = TypeVar("Settings")

_WORDS = {float: "a finite number", int: "a whole number", bool: "true or false", str: "a text"}


def read_table(
    cls: type[Settings], table: Any, source: str, section: str, also: Collection[str] = ()
) -> Settings:
    """Make a ``cls`` from the keys of ``table``; what is absent keeps its default.

    ``source`` names the file and ``section`` the table in messages; keys in ``also`` are someone
    else's to read. Only fields of type float, int, bool and str can be read. Raises InputError
    for an unknown key and for a value of another type.
    """
    if not isinstance(table, Mapping):
        raise InputError(
            f"{source}: key {section} is {table!r}, expected a table; write [{section}] and its "
            f"keys below"
        )
    kinds = typing.get_type_hints(cls)
    fields = [field.name for field in dataclasses.fields(cls) if kinds[field.name] in _WORDS]  # type: ignore[arg-type]
    prefix = f"{section}." if section else ""
    for key in table:
        if key not in fields and key not in also:
            known = ", ".join([*fields, *also])
            raise InputError(
                f"{source}: unknown key {prefix}{key}, expected one of {known}; rename or remove it"
            )
    values = {
        key: _value(table[key], kinds[key], f"{source}: key {prefix}{key}")
        for key in fields
        if key in table
    }
    return cls(**values)


def read_number(value: Any, where: str) -> float:
    """A finite number; InputError begins with ``where``."""
    return float(_value(value, float, where))


def require(holds: bool, source: Path | str, key: str, value: object, expected: str) -> None:
    """Raise InputError that ``key`` is ``value`` and what was ``expected``, unless it holds."""
    if not holds:
        raise InputError(
            f"{source}: key {key} is {value!r}, expected {expected}; correct that value"
        )


def _value(value: Any, kind: type, where: str) -> Any:
    right = isinstance(value, (int, float) if kind is float else kind)
    if right and isinstance(value, bool) == (kind is bool):
        if kind is not float:
            return value
        if math.isfinite(value):
            return float(value)
    raise InputError(f"{where} is {value!r}, expected {_WORDS[kind]}; correct that value")
