"""The report: one HTML file that tells what was missing, for someone new to the program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.models.effects import Effect
    from servosight.sources import Source

__all__ = ["write_report"]


def write_report(
    path: Path | str,
    result: Diagnosis | Comparison,
    recordings: Source | Sequence[Source] | None = None,
    catalogue: Mapping[str, Effect] | None = None,
    *,
    at: datetime | None = None,
    command: str | None = None,
) -> None:
    """Write a self-contained page, whole or not at all; InputError where it cannot be written.

    ``recordings`` are those of the result, or their paths: fitted, validation, test (default: read
    from where they were). ``catalogue`` has the result's effects (default: the built-in ones).
    ``at`` and ``command`` say when and with which command line the page is made. The same arguments
    give the same bytes.
    """
    from servosight.app.report.page import Made, page
    from servosight.app.report.story import Story
    from servosight.models.core import views, write_text
    from servosight.models.effects import catalogue as built_in
    from servosight.sources import read_all

    effects = built_in() if catalogue is None else catalogue
    given = read_all(_places(result) if recordings is None else recordings)
    write_text(Path(path), page(Story.of(result, views(given), effects), Made(at, command)))


def _places(result: Diagnosis | Comparison) -> list[Path]:
    """Where the recordings of a result were; InputError where it does not say."""
    from servosight.diagnose import Diagnosis
    from servosight.models.core import InputError

    places = [one.path for one in result.recordings] if isinstance(result, Diagnosis) else [None]
    known = [place for place in dict.fromkeys(places) if place is not None]
    if None in places:
        raise InputError(
            "report: the result does not say where its recordings are, expected them as well; name "
            "them in the order in which they were given"
        )
    return known
