"""Logs of other programs, read as recordings: one file a format.

A format NAME is a module ``formats/_NAME.py`` with two functions: ``recognises(path, start)`` says
whether a file that begins with the bytes ``start``, or a folder, is one of its own, and
``read_NAME(path, request)`` makes a recording of it.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from servosight.models.core import InputError, Recording, check_path
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._kinds import unknown_kind
from servosight.models.io.importers._raw import Raw
from servosight.models.io.importers._request import Column, Request, check_distinct, parse_map
from servosight.models.io.importers._units import units_of
from servosight.models.io.tables import UTF_16

_NAMES = (
    "lerobot",
    "rosbag",
    "ulog",
    "parquet",
    "numpy",
    "mat",
    "bam",
    "json_log",
    "table",
)
"""In the order in which they are asked; the first that recognises a file reads it."""
START_BYTES = 1 << 16
_RESULT = re.compile(rb'\{\s*"schema": \d+,\s*"type": "(fit|comparison|diagnosis|change)"')
"""How the JSON of a result begins that has a model (docs/json.md)."""


@dataclass(frozen=True)
class Format:
    """A log format: its name, how it is recognised, and how it is read."""

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path, Request], Recording]


def _format(name: str) -> Format:
    module = import_module(f"servosight.models.io.importers.formats._{name}")
    return Format(name, module.recognises, getattr(module, f"read_{name}"))


FORMATS: tuple[Format, ...] = tuple(map(_format, _NAMES))


def recognised(path: Path) -> Format | None:
    """The format of a file or folder by its content; None where none recognises it."""
    start = b"" if path.is_dir() else _start(path)
    return next((one for one in FORMATS if one.recognises(path, start)), None)


def import_recording(source: Path, request: Request) -> Recording:
    """Read a log of another program; InputError says what in it is no recording.

    ``notes`` of the recording say what the user should know about how it was read.
    """
    check_path(source)
    if not source.exists():
        raise InputError(f"{source}: no such file, expected a log to import; check the name")
    _refuse_result(source)
    found = recognised(source)
    if found is None:
        what, remedy = (
            ("is a folder of no known format", "name one file in it")
            if source.is_dir()
            else unknown_kind(_start(source))
        )
        raise InputError(
            f"{source}: {what}, expected a log of one of "
            f"{', '.join(one.name for one in FORMATS)}; {remedy}"
        )
    if request.command is None:
        check_distinct(str(source), request.columns)
    else:
        _check_command(source, found.name, request.command)
    return found.read(source, request)


def _refuse_result(source: Path) -> None:
    """InputError where a file is what servosight made of recordings: no log, and no model card."""
    kind = _RESULT.match(b"" if source.is_dir() else _start(source))
    if kind is not None:
        raise InputError(
            f"{source}: is a {kind[1].decode()} that servosight wrote as JSON, expected a "
            f"recording or a model; where its model is meant, give the model card that "
            f"-o MODEL.toml writes"
        )


def _check_command(source: Path, name: str, command: Path) -> None:
    """InputError unless angle and command are tables both: other formats hold them in one file."""
    check_path(command)
    if not command.exists():
        raise InputError(
            f"{command}: no such file, expected a log with the command; check the name"
        )
    other = recognised(command)
    wrong = source if name != "table" else command
    if name != "table" or other is None or other.name != "table":
        raise InputError(
            f"{wrong}: is no table of text, expected one where the command has a file of "
            f"its own; export both as CSV files"
        )


def _start(path: Path) -> bytes:
    """The first bytes of a regular file; of one in UTF-16 those in UTF-8."""
    try:
        # Without blocking: to open a pipe that nothing writes to would wait for ever.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(handle, "rb") as stream:
            if stat.S_ISREG(os.fstat(handle).st_mode):
                start = stream.read(START_BYTES)
                if start.startswith(UTF_16):
                    return start.decode("utf-16", "ignore").encode()
                return start
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}), expected a log to import; check the name "
            f"and the permissions"
        ) from None
    raise InputError(f"{path}: is no file, expected a log to import; name the file itself")


__all__ = [
    "FORMATS",
    "Column",
    "Format",
    "Raw",
    "Request",
    "assemble",
    "check_distinct",
    "import_recording",
    "parse_map",
    "recognised",
    "units_of",
]
