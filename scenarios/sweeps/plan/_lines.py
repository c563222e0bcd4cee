"""The line of a key in a TOML file, for messages about the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from servosight.models.core import InputError

_TABLE = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]\s*(#.*)?$")
_KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
_PART = re.compile(r"""[\w-]+|"[^"]*"|'[^']*'""")
_NAMED = re.compile(r"key ([^\s,]+(?:, [\w.]+(?= is))?)")


def line_of(text: str, key: str) -> int | None:
    """The line (from 1) that sets ``key``, or the nearest table above it; None without either.

    ``key`` may lack the table ``axes`` in which a key of the scenario stands as one name.

    >>> line_of('seeds = 3\\n[axes]\\n"camera.rate_hz" = [30]', "camera.rate_hz")
    3
    """
    found: dict[str, int] = {}
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if head := _TABLE.match(line):
            table = _joined(head[1]) + "."
            found.setdefault(table[:-1], number)
        elif entry := _KEY.match(line):
            found.setdefault(table + _joined(entry[1]), number)
    for place in _places(key):
        for name in (f"axes.{place}", place, f"scenario.{place}"):
            if name in found:
                return found[name]
        for name, number in found.items():  # one of several names of an axis
            if name.startswith("axes.") and place in re.split(r"\s*,\s*", name[5:]):
                return number
    return None


@contextmanager
def with_lines(source: str, text: str) -> Iterator[None]:
    """Add the line of the key that an InputError about ``source`` names."""
    try:
        yield
    except InputError as error:
        message = str(error)
        named = _NAMED.search(message)
        line = line_of(text, named[1].rstrip(":;")) if named else None
        if line is None or not message.startswith(f"{source}: "):
            raise
        raise InputError(f"{source}, line {line}: {message[len(source) + 2 :]}") from None


def _joined(dotted: str) -> str:
    return ".".join(part.strip("\"'") for part in _PART.findall(dotted))


def _places(key: str) -> Iterator[str]:
    """The key, then the tables that hold it."""
    while key:
        yield key
        key = key.rpartition(".")[0]
