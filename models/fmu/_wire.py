"""Messages between the program and the process that runs an FMU: JSON and arrays of float64.

What comes back is not trusted: an FMU may write into its own process as it likes. So sizes are
limited and nothing but numbers and plain JSON is read.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from servosight.models.core import Array

_HEAD = struct.Struct(">4sII")
_MAGIC = b"FMU1"
LARGEST_TEXT = 1 << 24
LARGEST_NUMBERS = 1 << 28


class Broken(Exception):
    """What came back is no message."""


def packed(table: dict[str, Any], arrays: Sequence[Array] = ()) -> bytes:
    """A message: a table, and arrays (any,) behind it."""
    parts = [np.ascontiguousarray(one, dtype="<f8").tobytes() for one in arrays]
    text = json.dumps({"table": table, "sizes": [len(one) // 8 for one in parts]}).encode()
    body = b"".join(parts)
    return _HEAD.pack(_MAGIC, len(text), len(body) // 8) + text + body


def received(read: Callable[[int], bytes]) -> tuple[dict[str, Any], list[Array]]:
    """The next message; ``read`` gives exactly so many bytes. Raises Broken."""
    magic, length, count = _HEAD.unpack(read(_HEAD.size))
    if magic != _MAGIC or length > LARGEST_TEXT or count > LARGEST_NUMBERS:
        raise Broken
    try:
        message = json.loads(read(length))
        sizes = [int(size) for size in message["sizes"]]
        table = message["table"]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise Broken from None
    if any(size < 0 for size in sizes) or sum(sizes) != count or not isinstance(table, dict):
        raise Broken
    numbers = np.frombuffer(read(8 * count), dtype="<f8").astype(np.float64)
    return table, list(np.split(numbers, np.cumsum(sizes)[:-1])) if sizes else []
