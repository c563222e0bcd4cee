"""The report: one HTML file that shows what was missing, for someone new to the program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.diagnose.change import ServoChange
    from servosight.models.effects import Effect
    from servosight.sources import Source

__all__ = ["write_report"]


def write_report(
    path: Path | str,
    result: Diagnosis | Comparison | ServoChange,
    recordings: Source | Sequence[Source] | None = None,
    catalogue: Mapping[str, Effect] | None = None,
    *,
    at: datetime | None = None,
    command: str | None = None,
) -> None:
    """Write a self-contained page, completely or not at all; InputError where it cannot be written.

    ``recordings`` are those of the result, or their paths: fitted, validation, test (default: those
    it remembers, or where they were). ``catalogue`` has the result's effects (default: those it was
    made with, or the built-in ones).
    Of what differs between two servos all is in the result.
    ``at`` and ``command`` say when and with which command line the page is made. The same arguments
    give the same bytes.
    """
    from servosight.app.report.change import sections, side_names
    from servosight.app.report.page import Made, page, page_of
    from servosight.app.report.story import Story
    from servosight.diagnose.change import ServoChange
    from servosight.models.core import views, write_text
    from servosight.models.effects import catalogue as built_in
    from servosight.sources import read_all

    if isinstance(result, ServoChange):
        parts = sections(result, catalogue or built_in())
        write_text(Path(path), page_of(parts, side_names(result), Made(at, command)))
        return
    effects = catalogue or result.known_effects or built_in()
    given = read_all(result.sources() if recordings is None else recordings)
    write_text(Path(path), page(Story.of(result, views(given), effects), Made(at, command)))
