"""Files as users give them: regular, of bounded size, in UTF-8, nested no deeper than is read."""

from __future__ import annotations

import errno
import json
import os
import re
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from servosight.models.base._errors import InputError

LARGEST_SETTINGS = 2 << 20
"""Bytes of a settings file; the largest that is written here, track.toml, has some 100,000."""
LARGEST_TABLE = 1 << 30
"""Bytes of a table of measurements."""
LARGEST_LOG = 1 << 28
"""Bytes of a log in JSON, which takes ten times as much memory when it is read."""
DEEPEST = 12
"""Levels of nesting in a settings file; those of servosight use four."""

_LONGEST_SHOWN = 100
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DOTTED = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*+")
_ENDS_KEY = re.compile(r"[ \t]*+[=\]]")
_INTEGERS = range(-(2**63), 2**63)


def shown(path: Path | str) -> str:
    """A path as messages show it: on one line, printable, its middle left out where it is long."""
    text = str(path).encode("utf-8", "backslashreplace").decode("utf-8")
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    half = _LONGEST_SHOWN // 2
    return text if len(text) <= 2 * half else f"{text[:half]}...{text[-half:]}"


def plain_name(name: str) -> str:
    """A file's name as text that any file can hold: what is not UTF-8 becomes U+FFFD."""
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def check_path(path: Path) -> None:
    """Refuse a name that no file can have, or a place that may not be looked at.

    A path at which nothing stands yet is accepted.
    """
    try:
        os.stat(path)
    except ValueError:  # a NUL, or a character that the file system cannot hold
        reason = "the name holds a character that no file name can have"
    except OSError as error:
        if error.errno in (errno.ENOENT, errno.ENOTDIR):
            return
        reason = error.strerror or str(error)
    else:
        return
    raise InputError(
        f"{shown(path)}: cannot be opened ({reason}); expected the name of a file or folder that "
        f"you may use, so correct the name or its permissions"
    )


def read_bytes(path: Path, expected: str, largest: int) -> bytes:
    """The content of a regular file of at most ``largest`` bytes.

    ``expected`` names the kind of file in messages ("a CSV file"). Raises InputError where the
    file is missing, a folder, a device or a pipe, too large, or cannot be read.
    """
    check_path(path)
    name = shown(path)
    try:
        # Without blocking: to open a pipe that nothing writes to would wait for ever.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(handle, "rb") as stream:
            if not stat.S_ISREG(os.fstat(handle).st_mode):
                raise InputError(f"{name}: is no file, expected {expected}; name the file itself")
            data = stream.read(largest + 1)
    except FileNotFoundError:
        raise InputError(f"{name}: no such file, expected {expected}; check the name") from None
    except OSError as error:
        what = "is no file" if error.errno == errno.EISDIR else "cannot be read"
        raise InputError(
            f"{name}: {what} ({error.strerror}), expected {expected}; check the name and the "
            f"permissions"
        ) from None
    if len(data) > largest:
        raise InputError(
            f"{name}: the file has more than {largest:,} bytes, the most that is read; expected "
            f"{expected}, so check that it is the right file or cut it into parts"
        )
    return data


def read_text(path: Path, expected: str, largest: int = LARGEST_SETTINGS) -> str:
    """The text of a regular file in UTF-8, a byte-order mark left out; otherwise InputError."""
    data = read_bytes(path, expected, largest)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{shown(path)}, row {line}: byte 0x{data[error.start]:02x} is not UTF-8, expected "
            f"{expected}; save the file as plain text in UTF-8"
        ) from None


def read_settings(
    path: Path,
    expected: str = "settings in TOML",
    *,
    form: Literal["TOML", "JSON"] = "TOML",
    largest: int = LARGEST_SETTINGS,
) -> dict[str, Any]:
    """The table of a TOML file, or the object of a JSON file; otherwise InputError.

    The one way in which servosight reads such files. The table is nested at most ``DEEPEST``
    levels and its whole numbers have at most 64 bits, so that whoever walks it, shows it or makes
    floats of it can rely on that. ``expected`` names the kind of file in messages.
    """
    text = read_text(path, expected, largest)
    name = shown(path)
    try:
        if form == "JSON":
            table = json.loads(text)
        else:
            _check_keys(name, text)
            table = tomllib.loads(text)
    except RecursionError:
        raise _too_deep(name) from None
    except ValueError as error:
        raise InputError(
            f"{name}: is no {form} ({_shortened(error)}), expected {expected}; correct that place"
        ) from None
    if not isinstance(table, dict):
        raise InputError(f"{name}: holds no table, expected {expected}; check the name")
    _check_values(name, table)
    return table


def _check_keys(name: str, text: str) -> None:
    """Refuse a dotted key of very many parts, over which tomllib takes quadratic time."""
    for found in _DOTTED.finditer(text):  # longest runs, none looked at twice: linear time
        if found.group().count(".") >= DEEPEST and _ENDS_KEY.match(text, found.end()):
            line = text.count("\n", 0, found.start()) + 1
            raise InputError(
                f"{name}, row {line}: the key {shown(found.group())} has more than {DEEPEST} "
                f"parts, expected a few; shorten it"
            )


def _check_values(name: str, table: Mapping[str, Any]) -> None:
    level: list[tuple[str, Any]] = [("", table)]
    for _ in range(DEEPEST):
        below: list[tuple[str, Any]] = []
        for key, value in level:
            if isinstance(value, Mapping):
                below += [(f"{key}.{one}" if key else one, value[one]) for one in value]
            elif isinstance(value, list):
                below += [(key, one) for one in value]
            elif isinstance(value, int) and value not in _INTEGERS:
                raise InputError(
                    f"{name}: key {shown(key)} is a whole number of {value.bit_length()} bits, "
                    f"expected at most 64; write a smaller number"
                )
        if not below:
            return
        level = below
    raise _too_deep(name)


def _too_deep(name: str) -> InputError:
    return InputError(
        f"{name}: is no TOML or JSON that can be read, for tables or lists are nested more than "
        f"{DEEPEST} levels deep in each other, expected a few; check that it is the right file"
    )


def _shortened(error: Exception) -> str:
    return shown(" ".join(str(error).split()))
