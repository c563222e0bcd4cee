"""How far long work is: a bar on a terminal, or lines with the time that each stage took."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

PACE = "frames/s"
"""A word with this ending gives the speed: it is the same stage at another speed."""


class Amount(Enum):
    """How much the command that runs says."""

    QUIET = 0
    NORMAL = 1
    VERBOSE = 2


_amount = [Amount.NORMAL]


def set_amount(*, quiet: bool, verbose: bool) -> None:
    """Choose how much is said from now on."""
    _amount[0] = Amount.QUIET if quiet else Amount.VERBOSE if verbose else Amount.NORMAL


def quiet() -> bool:
    """True where nothing but JSON and errors is wanted."""
    return _amount[0] is Amount.QUIET


class Shown:
    """What shows the stages of a work; this one shows nothing."""

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """The stage, what is done and, where it is known, of how much."""

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Leave the terminal to a question for the body of a ``with``."""
        yield


@contextmanager
def progress(title: str) -> Iterator[Shown]:
    """Show on standard error how far the block is; silent where that is no terminal.

    With ``--verbose`` each stage is a line with the seconds that it took, on a terminal or not.
    """
    if _amount[0] is Amount.VERBOSE:
        stages = _Stages(title)
        try:
            yield stages
        finally:
            stages.end()
    elif quiet() or not sys.stderr.isatty():
        yield Shown()
    else:
        with _bar(title) as show:
            yield show


class _Stages(Shown):
    """Prints each stage of a work as it ends, and the whole work behind them."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.stage = ""
        self.began = self.stage_began = time.perf_counter()
        self._say(f"{title} ...")

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """Another stage: the one before has ended."""
        name = "" if stage.endswith(PACE) else stage
        if name != self.stage:
            self._end_stage()
            self.stage, self.stage_began = name, time.perf_counter()

    def end(self) -> None:
        """The work has ended, be it by an error."""
        self._end_stage()
        self._say(f"{self.title}: {time.perf_counter() - self.began:.1f} s")

    def _end_stage(self) -> None:
        if self.stage:
            self._say(f"  {self.stage}: {time.perf_counter() - self.stage_began:.1f} s")

    @staticmethod
    def _say(words: str) -> None:
        print(words, file=sys.stderr, flush=True)


class _Bar(Shown):
    """A bar that lives on the terminal's last line."""

    def __init__(self, title: str, bar: Progress) -> None:
        self._title, self._bar = title, bar
        self._task = bar.add_task(title, total=None)

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        words = f"{self._title}: {stage}"
        self._bar.update(self._task, description=words, completed=done, total=total)

    @contextmanager
    def hidden(self) -> Iterator[None]:
        self._bar.stop()
        try:
            yield
        finally:
            self._bar.start()


@contextmanager
def _bar(title: str) -> Iterator[Shown]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        yield _Bar(title, bar)
