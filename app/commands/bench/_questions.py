"""Questions in the terminal: one sentence, a default, and a way out at each of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TypeVar

from servosight.models.base import InputError

END = "q"
T = TypeVar("T")


class Ended(Exception):
    """The user has had enough."""


def check_terminal(command: str) -> None:
    """Raise InputError where nobody can answer."""
    if not sys.stdin.isatty():
        raise InputError(
            f"{command}: asks questions, and standard input is no terminal; run it in one, or give "
            f"the answers as options to the other actions of `servosight bench`"
        )


def ask(
    question: str, default: str | None = None, refuse: Callable[[str], str | None] | None = None
) -> str:
    """The answer, asked again while ``refuse`` has a sentence against it; an empty one: default.

    Raises Ended for ``q`` and at the end of the input.
    """
    shown = "" if default is None else f" [{default}]"
    while True:
        # Not by input(), whose prompt goes to the descriptor that native libraries are kept from.
        print(f"{question}{shown} ", end="", flush=True)
        line = sys.stdin.readline()
        if not line:
            print()
            raise Ended
        answer = line.strip()
        if answer.lower() == END:
            raise Ended
        answer = answer or default or ""
        against = refuse(answer) if refuse is not None else None
        if against is None:
            return answer
        print(f"  {against}")


def agree(question: str, *, default: bool = True) -> bool:
    """Yes or no."""
    answer = ask(question, "yes" if default else "no", _yes_or_no)
    return answer.lower() in ("y", "yes")


def number(question: str, default: str, least: float, most: float, *, whole: bool = False) -> str:
    """A number within a range, as it was typed."""

    def refuse(answer: str) -> str | None:
        try:
            value = int(answer) if whole else float(answer)
        except ValueError:
            return f"{answer!r} is no {'whole ' if whole else ''}number; type one such as {default}"
        if not least <= value <= most:
            return f"{answer} is out of range; type a number from {least:g} to {most:g}"
        return None

    return ask(question, default, refuse)


def choose(question: str, choices: Sequence[T], other: str | None = None) -> T | str:
    """One of some choices by its number; with ``other``, also whatever else is typed.

    A choice is shown as ``str`` has it; ``other`` says what else can be typed.
    """
    for count, choice in enumerate(choices, 1):
        print(f"  {count}  {choice}")
    if other is not None:
        print(f"  or {other}")

    def refuse(answer: str) -> str | None:
        if answer.isascii() and answer.isdigit():
            if 1 <= int(answer) <= len(choices):
                return None
        elif other is not None and answer:
            return None
        return f"type a number from 1 to {len(choices)}" if choices else f"type {other}"

    answer = ask(question, "1" if choices else None, refuse)
    return choices[int(answer) - 1] if answer.isascii() and answer.isdigit() else answer


def _yes_or_no(answer: str) -> str | None:
    return None if answer.lower() in ("y", "yes", "n", "no") else "type yes or no"
