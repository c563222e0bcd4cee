"""The keys behind the question mark of a camera's address."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeVar
from urllib.parse import parse_qsl

from servosight.models.core import InputError, did_you_mean, validated

T = TypeVar("T")


def read_settings(address: str, kind: type[T], texts: tuple[str, ...] = ()) -> T:
    """The settings that an address gives, as a dataclass ``kind``; all but ``texts`` are numbers.

    Raises InputError for a key that the kind does not have and for values out of range.
    """
    query = address.partition("?")[2]
    shape: Any = kind
    known = {field.name for field in fields(shape)}
    values: dict[str, object] = {}
    for key, text in parse_qsl(query, keep_blank_values=True):
        if key not in known:
            raise InputError(
                f"{address}: no key {key}{did_you_mean(key, known)}, expected one of "
                f"{', '.join(sorted(known))}; correct the address"
            )
        values[key] = text if key in texts else _number(address, key, text)
    return validated(values, kind, address)


def _number(address: str, key: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{address}: {key} is {text!r}, expected a number; correct it") from None
    return int(value) if value.is_integer() else value
