"""The one exception that a user's own input can cause."""

from __future__ import annotations


class InputError(Exception):
    """Bad input or usage.

    The message is one sentence that names the file, the row or key, what was expected and how to
    mend it. The command line prints it and exits with code 2.
    """
