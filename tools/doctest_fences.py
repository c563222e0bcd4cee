"""Extension of griffe: examples in docstrings become blocks of code instead of quotations."""

from __future__ import annotations

import re
from typing import Any

import griffe

EXAMPLE = re.compile(r"^>>> .*(?:\n.+)*", re.MULTILINE)


def fenced(text: str) -> str:
    """``text`` with each example, which ends at an empty line, as a block of code."""
    return EXAMPLE.sub(lambda match: f"```pycon\n{match[0]}\n```", text)


class DoctestFences(griffe.Extension):
    """Applies :func:`fenced` to every docstring."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """An object has been loaded."""
        if obj.docstring is not None:
            obj.docstring.value = fenced(obj.docstring.value)
