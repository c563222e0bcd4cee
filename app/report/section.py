"""A part of the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Section:
    """``values`` fill the template ``name``.html; ``name`` is also the anchor."""

    name: str
    title: str
    values: Mapping[str, Any]
