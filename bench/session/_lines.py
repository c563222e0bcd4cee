"""A line of a check."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a check: what, whether it is in order, and the value or how to correct it."""

    what: str
    good: bool
    words: str


def line_of(what: str, good: bool, words: str, correction: str) -> Line:
    """A line with its value, and with one sentence on how to correct it where that is needed."""
    return Line(what=what, good=good, words=words if good else f"{words}; {correction}")
