"""JSON in and out: plain values, never NaN or Infinity."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from servosight.models.base._files import LARGEST_LOG, read_settings


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
