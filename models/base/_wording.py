"""Words of messages that a user of Python and one of the command line both read."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path


def either(python: str, option: str) -> str:
    """How something is given in Python, and how on the command line.

    >>> either("force=True", "--force")
    'force=True (--force on the command line)'
    """
    return f"{python} ({option} on the command line)"


def column_map(quantity: str, column: str) -> str:
    """How a quantity's column is named; on the command line quoted for a shell.

    >>> column_map("angle", "pos:rad")
    "columns={'angle': 'pos:rad'} (--map angle=pos:rad on the command line)"
    """
    option = f"--map {shlex.quote(f'{quantity}={column}')}"
    return either(f"columns={{{quantity!r}: {column!r}}}", option)


def column_maps(
    columns: Mapping[str, str], path: Path | None = None, unit: str | None = None
) -> str:
    """How the columns of several quantities are named; on the command line as a whole command where
    ``path`` is the log.

    >>> column_maps({"time": "t [ms]", "angle": "pos:rad"}, Path("a.csv")).partition(" (")[2]
    "`servosight import a.csv -o REC --map 'time=t [ms]' --map angle=pos:rad` on the command line)"
    """
    words = [] if path is None else [f"servosight import {shlex.quote(str(path))} -o REC"]
    words += [f"--map {shlex.quote(f'{name}={one}')}" for name, one in columns.items()]
    words += [f"--unit {shlex.quote(unit)}"] if unit else []
    return either(f"columns={dict(columns)}", f"`{' '.join(words)}`")
