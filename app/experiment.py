"""A filmed experiment in a folder: measure and diagnose its recording, write what was found."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.terminal import check_target, made, progress, show_diagnosis
from servosight.models.base import Kind

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.diagnose import Diagnosis
    from servosight.models.core import Recording

DIAGNOSIS, REPORT = "diagnosis.json", "report.html"


def check_written(folder: Path, *, force: bool) -> None:
    """Refuse, before the work begins, a folder whose diagnosis or report must not be replaced."""
    check_target(folder / DIAGNOSIS, Kind.JSON, force=force)
    check_target(folder / REPORT, Kind.HTML, force=force)


def diagnosed(place: Path, part: str, out: Console) -> tuple[Recording, Diagnosis]:
    """The angle of a part in a recording's film, and its diagnosis: steps 2 and 3 as printed."""
    from servosight.diagnose import diagnose
    from servosight.models.effects import catalogue
    from servosight.sources import read

    out.print(f"2. The camera measures the {part}'s angle.")
    with progress("tracking") as show:
        recording = read(place, progress=show)
    out.print("3. The model is compared with the measurement: what is missing?")
    with progress("diagnosing") as show:
        result = diagnose([recording], catalogue=catalogue(), auto=True, progress=show)
    return recording, result


def write_found(
    folder: Path,
    result: Diagnosis,
    recordings: Sequence[Recording],
    args: argparse.Namespace,
    out: Console,
) -> None:
    """Write the diagnosis and its report, and show it."""
    from servosight.app.report import write_report
    from servosight.models.base import json_text, write_text

    values = result.to_dict()
    write_text(folder / DIAGNOSIS, json_text(values))
    with progress("writing the report"):
        write_report(folder / REPORT, result, recordings, **made(args))
    show_diagnosis(out, values)
