"""A quantity of a log as it stands in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servosight.models.core import Array


@dataclass(frozen=True)
class Raw:
    """A quantity as it stands in the log: its column, unit, numbers (rows,) and their places.

    ``path`` is the file that holds it, where that is not the log itself.
    """

    column: str
    unit: str
    values: Array
    rows: Sequence[int]
    word: str
    path: Path | None = None
