"""The one exception that a user's own input can cause."""

from __future__ import annotations

from collections.abc import Iterable


class InputError(Exception):
    """Bad input or usage.

    The message is one sentence that names the file, the row or key, what was expected and how to
    fix it. The command line prints it and exits with code 2.

    >>> import servosight as ss
    >>> try:
    ...     ss.read("run7")
    ... except ss.InputError as error:
    ...     print(error)
    run7: no such file or folder, expected a recording; check the name
    """


def did_you_mean(name: str, known: Iterable[str], prefix: str = "") -> str:
    """The known name that a misspelt one is closest to, as a question; empty without one.

    ``prefix`` is what all names begin with: it is shown, and does not make names alike.

    >>> did_you_mean("baklash", ["dead_time", "backlash"])
    ' (did you mean backlash?)'
    """
    import difflib  # only where something is wrong

    close = difflib.get_close_matches(name, list(known), n=1)
    return f" (did you mean {prefix}{close[0]}?)" if close else ""
