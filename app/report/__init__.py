"""The report: one HTML file that tells what was missing, for someone new to the program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.models.core import Recording
    from servosight.models.effects import Effect

__all__ = ["write_report"]


def write_report(
    path: Path,
    result: Diagnosis | Comparison,
    recordings: Sequence[Recording],
    catalogue: Mapping[str, Effect] | None = None,
    *,
    at: datetime | None = None,
    command: str | None = None,
) -> None:
    """Write a self-contained page, whole or not at all; InputError where it cannot be written.

    ``recordings`` are those of the result: fitted, validation, test; ``catalogue`` has its effects
    (default: the built-in ones). ``at`` and ``command`` say when and with which command line it is
    made. The same arguments give the same bytes.
    """
    from servosight.app.report.page import Made, page
    from servosight.app.report.story import Story
    from servosight.models.core import write_text
    from servosight.models.effects import catalogue as built_in

    effects = built_in() if catalogue is None else catalogue
    write_text(path, page(Story.of(result, recordings, effects), Made(at, command)))
