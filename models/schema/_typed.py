"""What was saved as JSON, read back as dataclasses."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

import msgspec
import numpy as np

from servosight.models.base import InputError, read_json

T = TypeVar("T")


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
    origin = get_origin(kind) or kind
    if origin is np.ndarray:
        (number,) = get_args(get_args(kind)[1])
        return np.array(value, dtype=number)
    if issubclass(origin, Path):
        return Path(value)
    if issubclass(origin, tuple):  # Table
        return origin(msgspec.convert(value, list[get_args(kind)[0]], dec_hook=_decoded))  # type: ignore[misc]
    raise NotImplementedError(f"no rule to read a {kind}")
