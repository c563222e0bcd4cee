"""The one function of these packages that calls the report, which is in a layer above."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any

from servosight.models.effects import Effect


def write_report(
    path: Path | str, result: Any, recordings: Any, catalogue: Mapping[str, Effect] | None
) -> None:
    """Write the report of a ``result``, so that each result can offer this as its own method.

    The import by name, when called, is the exception that docs/architecture.md states.
    """
    write = import_module("servosight.app.report").write_report
    write(path, result, recordings, catalogue, at=datetime.now(UTC))
