"""Logs of other programs, read as recordings: one file a format.

A format is a function ``(path, request) -> Imported``; ``FORMATS`` says which file name it takes.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from servosight.models.core import InputError, check_path
from servosight.models.io.importers._request import (
    Column,
    Imported,
    Raw,
    Request,
    assemble,
    parse_map,
    unit_of,
)
from servosight.models.io.importers._table import read_table

_READERS = {
    ".json": "bam",
    ".mat": "mat",
}
"""By the ending of a file's name: NAME is the function ``read_NAME`` in the file ``_NAME.py``."""

FORMATS: dict[str, Callable[[Path, Request], Imported]] = {
    ending: getattr(import_module(f"servosight.models.io.importers._{name}"), f"read_{name}")
    for ending, name in _READERS.items()
}
"""Readers by the ending of the name; whatever else is read as a table of text."""


def import_recording(source: Path, request: Request) -> Imported:
    """Read a log of another program; InputError says what in it is no recording."""
    check_path(source)
    if not source.is_file():
        raise InputError(f"{source}: no such file, expected a log to import; check the name")
    return FORMATS.get(source.suffix.lower(), read_table)(source, request)


__all__ = [
    "FORMATS",
    "Column",
    "Imported",
    "Raw",
    "Request",
    "assemble",
    "import_recording",
    "parse_map",
    "unit_of",
]
