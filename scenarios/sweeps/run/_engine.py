"""What runs batches: here, one after the other in this process; with Dask in ``_dask``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from servosight.scenarios.sweeps.run._batch import BatchReport, Task, Work, run_batch
from servosight.scenarios.sweeps.run._watch import WatchLimits

Outcome = tuple[tuple[Task, ...], BatchReport | None]
"""A batch and its report; None where the worker that ran it was lost."""


class Engine(Protocol):
    """Accepts batches and gives them back when they are done, in any order."""

    @property
    def workers(self) -> int:
        """How many batches run at once."""

    def submit(self, tasks: Sequence[Task]) -> None:
        """Run a batch some time."""

    def wait(self) -> Outcome:
        """The next batch that is done; there is one in flight."""


@dataclass
class InThisProcess:
    """Runs each batch when it is waited for: for small sweeps, debugging and tests.

    Cells have no limits here, as one that exceeds them would end this process.
    """

    work: Work
    folder: Path
    workers: int = 1
    _queue: list[tuple[Task, ...]] = field(default_factory=list)

    def submit(self, tasks: Sequence[Task]) -> None:
        """Remember a batch."""
        self._queue.append(tuple(tasks))

    def wait(self) -> Outcome:
        """Run the oldest batch."""
        tasks = self._queue.pop(0)
        return tasks, run_batch(self.work, tasks, str(self.folder), WatchLimits())
