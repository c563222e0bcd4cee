"""Words of messages that a user of Python and one of the command line both read."""

from __future__ import annotations

import shlex


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
