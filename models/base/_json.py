"""JSON in and out: plain values, never NaN or Infinity, and typed values read back."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

import msgspec

from servosight.models.base._errors import InputError
from servosight.models.base._files import LARGEST_LOG, read_settings

T = TypeVar("T")


def plain(value: Any) -> Any:
    """``value`` in JSON's types: arrays as lists, dataclasses as tables, NaN and infinity as null.

    >>> plain({"x": (1.0, math.nan)})
    {'x': [1.0, None]}
    """
    if isinstance(value, Enum):
        return plain(value.value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return value


def json_text(value: Any) -> str:
    """JSON in the order of its keys, two spaces deep; never NaN or Infinity."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def read_json(path: Path | str) -> dict[str, Any]:
    """The object in a JSON file; InputError where there is none."""
    return read_settings(
        Path(path), "a result that servosight saved", form="JSON", largest=LARGEST_LOG
    )


def typed(table: Any, kind: type[T]) -> T:
    """``table`` as a ``kind``, such as a dataclass, every value checked; InputError names the key.

    Keys that ``kind`` does not have are passed over.
    """
    try:
        return msgspec.convert(table, kind, dec_hook=_decoded)
    except (msgspec.ValidationError, ValueError) as error:
        what = str(error).replace("`", "")
        raise InputError(f"{what}; correct that value, or save the result again") from None


def read_typed(path: Path | str, kind: type[T]) -> T:
    """The object in a JSON file as a ``kind``; InputError names the file and the key."""
    try:
        return typed(read_json(path), kind)
    except InputError as error:
        raise InputError(str(error) if str(path) in str(error) else f"{path}: {error}") from None


def _decoded(kind: Any, value: Any) -> Any:
    """What JSON has no type for."""
    import numpy as np  # not at the top: the command line's help comes without it

    origin = get_origin(kind) or kind
    if origin is np.ndarray:
        (number,) = get_args(get_args(kind)[1])
        return np.array(value, dtype=number)
    if issubclass(origin, Path):
        return Path(value)
    if issubclass(origin, tuple):  # Table
        return origin(msgspec.convert(value, list[get_args(kind)[0]], dec_hook=_decoded))  # type: ignore[misc]
    raise NotImplementedError(f"no rule to read a {kind}")
