"""How far long work is: a bar on a terminal, or lines with the time that each stage took.

The best answer of a search is a line of its own whenever there is a better one.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from typing import TYPE_CHECKING

from servosight.models.base import BEST_SO_FAR

if TYPE_CHECKING:
    from rich.progress import Progress

BAR = 20
"""Width of the bar: with it a stage and its count fit a terminal of 80 columns."""
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
    """What shows the stages of a work; this one shows the best answers of a search alone."""

    def __init__(self) -> None:
        self.best = ""

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """The stage, what is done and, where it is known, of how much; or the best answer."""
        if stage.startswith(BEST_SO_FAR):
            self.best = stage
            self.say(stage)
        else:
            self.show(stage, done, total)

    def show(self, stage: str, done: int, total: int | None) -> None:
        """A stage."""

    def say(self, words: str) -> None:
        """A line that stays."""
        print(words, file=sys.stderr, flush=True)

    def interrupted(self) -> None:
        """The work was interrupted: what a search had found by then, and that it is not its end."""
        if self.best:
            self.say(
                f"interrupted, {self.best}; this is not a finished diagnosis: the search had not "
                f"ended"
            )

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Leave the terminal to a question for the body of a ``with``."""
        yield


@contextmanager
def progress(title: str) -> Iterator[Shown]:
    """Show on standard error how far the block is; where that is no terminal, best answers alone.

    With ``--verbose`` each stage is a line with the seconds that it took, on a terminal or not.
    Where the block is interrupted, the best answer up to then is told as such.
    """
    with _shown(title) as show:
        try:
            yield show
        except KeyboardInterrupt:
            show.interrupted()
            raise


@contextmanager
def _shown(title: str) -> Iterator[Shown]:
    if quiet():
        yield _Silent()
    elif _amount[0] is Amount.VERBOSE:
        stages = _Stages(title)
        try:
            yield stages
        finally:
            stages.end()
    elif not sys.stderr.isatty():
        yield Shown()
    else:
        with _bar(title) as show:
            yield show


class _Silent(Shown):
    """Shows nothing."""

    def say(self, words: str) -> None:
        pass


class _Stages(Shown):
    """Prints each stage of a work as it ends, and the whole work behind them."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self.title = title
        self.stage = ""
        self.began = self.stage_began = time.perf_counter()
        self.say(f"{title} ...")

    def show(self, stage: str, done: int, total: int | None) -> None:
        """Another stage: the one before has ended."""
        name = "" if stage.endswith(PACE) else stage
        if name != self.stage:
            self._end_stage()
            self.stage, self.stage_began = name, time.perf_counter()

    def end(self) -> None:
        """The work has ended, be it by an error."""
        self._end_stage()
        self.say(f"{self.title}: {time.perf_counter() - self.began:.1f} s")

    def _end_stage(self) -> None:
        if self.stage:
            self.say(f"  {self.stage}: {time.perf_counter() - self.stage_began:.1f} s")


class _Bar(Shown):
    """A bar that lives on the terminal's last line."""

    def __init__(self, title: str, bar: Progress) -> None:
        super().__init__()
        self._title, self._bar = title, bar
        self._task = bar.add_task(title, total=None)

    def show(self, stage: str, done: int, total: int | None) -> None:
        words = f"{self._title}: {stage}"
        self._bar.update(self._task, description=words, completed=done, total=total)

    def say(self, words: str) -> None:
        self._bar.console.print(words, markup=False, highlight=False)

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

    columns = (TextColumn("{task.description}", markup=False), BarColumn(BAR), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        yield _Bar(title, bar)
