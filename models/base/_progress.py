"""How long work reports its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

FrameProgress = Callable[[int, int], None]
"""Called with the number of frames done and the number of all frames."""


BEST_SO_FAR = "best so far: "
"""A stage of this beginning is what a search would answer by now: it is told whenever it changes,
and is shown as a line of its own."""


class StageProgress(Protocol):
    """Reports the progress of work that has several stages."""

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """``done`` of ``total`` (None: not known) steps of ``stage`` are done."""


def silent(stage: str, done: int, total: int | None = None) -> None:
    """Report nothing."""
