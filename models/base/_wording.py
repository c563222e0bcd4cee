"""Words of messages that a user of Python and one of the command line both read."""

from __future__ import annotations


def either(python: str, option: str) -> str:
    """How something is given in Python, and how on the command line.

    >>> either("force=True", "--force")
    'force=True (--force on the command line)'
    """
    return f"{python} ({option} on the command line)"


def column_map(quantity: str, column: str) -> str:
    """How a quantity's column is named.

    >>> column_map("angle", "pos:rad")
    "columns={'angle': 'pos:rad'} (--map angle=pos:rad on the command line)"
    """
    return either(f"columns={{'{quantity}': '{column}'}}", f"--map {quantity}={column}")
