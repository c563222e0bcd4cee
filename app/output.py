"""What leaves the program: JSON, human text and progress, each on its own way."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from servosight.models.atomic import check_target, write_text
from servosight.models.json_io import json_text

if TYPE_CHECKING:
    from rich.console import Console

STANDARD_OUTPUT = "-"
PIPED_WIDTH = 120


class Report(Protocol):
    """How work tells how far it is."""

    def __call__(self, word: str, done: int, total: int | None = None) -> None:
        """``done`` of ``total`` (None: not known) at what ``word`` says."""


def check_outputs(args: argparse.Namespace) -> None:
    """Refuse files that could not be written, before the work begins."""
    for name in ("output", "report", "json", "next_command", "draft", "overlay", "sheet"):
        place = getattr(args, name, None)
        if place is not None and place != STANDARD_OUTPUT:
            check_target(Path(place))


def write_json(place: str | None, value: Any) -> None:
    """Write JSON to a file, whole or not at all, or to standard output where ``place`` is ``-``."""
    if place is None:
        return
    text = json_text(value)
    if place == STANDARD_OUTPUT:
        sys.stdout.write(text)
        sys.stdout.flush()
    else:
        write_text(Path(place), text)


def console(args: argparse.Namespace) -> Console:
    """Where human text goes: standard output, unless JSON has that for itself."""
    from rich.console import Console

    class Plain(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    on_error = getattr(args, "json", None) == STANDARD_OUTPUT
    stream = sys.stderr if on_error else sys.stdout
    width = None if stream.isatty() else PIPED_WIDTH
    return Plain(stderr=on_error, width=width, markup=False, highlight=False, soft_wrap=True)


def next_command(*words: object) -> str:
    """The line that suggests a command, with names quoted as a shell needs them."""
    return f"Next: servosight {shlex.join(map(str, words))}"


@contextmanager
def progress(title: str) -> Iterator[Report]:
    """A bar on standard error while the block runs; silent where that is no terminal.

    Gives a function that takes a word, what is done and, where it is known, of how much.
    """
    if not sys.stderr.isatty():
        yield _silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)

        def report(word: str, done: int, total: int | None = None) -> None:
            bar.update(task, description=f"{title}: {word}", completed=done, total=total)

        yield report


def _silent(word: str, done: int, total: int | None = None) -> None:
    """Nobody watches."""
