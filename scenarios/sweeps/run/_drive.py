"""The driver: a window of batches in flight, lost workers, failures, what is said of progress."""

from __future__ import annotations

import itertools
import re
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from servosight.scenarios.sweeps.run._batch import (
    BatchReport,
    Task,
    failed_row,
    row_path,
    write_row,
)
from servosight.scenarios.sweeps.run._engine import Engine
from servosight.scenarios.sweeps.run._store import GATHERED, Store

AHEAD = 2
"""Batches in flight for each worker: one runs, one waits."""
BATCH_S = 2.0
"""Batches of short cells take about so long, which makes a task's own cost small."""
LARGEST_BATCH = 500
ALIKE = 3
"""So many failures of one kind are said, once."""
LOST = (
    "the worker ended while it ran this cell alone (killed, or native code crashed or exceeded the "
    "time limit)"
)

_NUMBERS = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?", re.IGNORECASE)


@dataclass
class Tally:
    """How far a run is."""

    total: int
    earlier: int = 0
    done: int = 0
    failed: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    began: float = field(default_factory=time.monotonic)
    latest: tuple[str, ...] = ()
    """Keys of the cells of the last batch."""

    @property
    def rate(self) -> float:
        """Cells a second since the first was submitted."""
        return self.done / max(time.monotonic() - self.began, 1e-9)

    @property
    def left_s(self) -> float | None:
        """Seconds until the end at this rate; None before the first cell is done."""
        if not self.done:
            return None
        return (self.total - self.earlier - self.done) / self.rate

    def words(self) -> str:
        """Rate, time left and failures, for a progress bar."""
        left = self.left_s
        rest = "" if left is None else f", {_time(left)} left"
        return f"{self.rate:.2g} cells/s{rest}, {self.failed} failed"

    def add(self, report: BatchReport) -> list[str]:
        """Count a batch; returns sentences on failures that have come up three times by now."""
        said = []
        self.latest = tuple(key for key, _ in report.errors)
        for _, error in report.errors:
            self.done += 1
            if error:
                self.failed += 1
                kind = _NUMBERS.sub("#", error)
                self.kinds[kind] += 1
                if self.kinds[kind] == ALIKE:
                    said.append(f"{ALIKE} cells have failed alike: {error}")
        return said


OnProgress = Callable[[Tally, Sequence[str]], None]


def drive(
    tasks: Iterator[Task], engine: Engine, store: Store, tally: Tally, on_progress: OnProgress
) -> None:
    """Run ``tasks`` that have no row yet. ``on_progress`` gets the tally and what is to be said.

    Of a worker that was lost every cell that it held is suspected: these run again, each alone on
    an otherwise idle engine, and one that takes its worker with it again is given up. Rows that are
    not in a part when an error or Ctrl-C ends this stay as they are: gathering takes too long then.
    """
    waiting = iter(tasks)
    left = tally.total - tally.earlier
    in_flight = 0
    suspects: deque[Task] = deque()
    finished: list[str] = []
    size, ended = 1, False
    while True:
        while not ended and not suspects and in_flight < AHEAD * engine.workers:
            batch = tuple(itertools.islice(waiting, _share(size, left, engine.workers)))
            left -= len(batch)
            ended = not batch
            if batch:
                engine.submit(batch)
                in_flight += 1
        alone = bool(suspects) and not in_flight
        if alone:
            engine.submit([suspects.popleft()])
            in_flight += 1
        if not in_flight:
            break
        batch, report = engine.wait()
        in_flight -= 1
        if report is None:
            report, lost = _without_report(batch, store, alone=alone)
            suspects.extend(lost)
        elif report.errors:
            size = _batch_size(size, report)
        finished += [key for key, _ in report.errors]
        on_progress(tally, tally.add(report))
        if len(finished) >= GATHERED:
            store.gather(finished)
            finished.clear()
    store.gather(finished)


def _without_report(
    batch: Sequence[Task], store: Store, *, alone: bool
) -> tuple[BatchReport, list[Task]]:
    """What a lost worker has left: the cells with a row, and those that are suspected.

    A cell that ran alone, and has no row, gets one that says that it was lost.
    """
    if alone:
        for task in batch:
            if not row_path(store.cells, task.key).exists():
                write_row(store.cells, task.key, {**failed_row(task, LOST), "seconds": None})
    rows = store.errors([task.key for task in batch])
    return BatchReport(tuple(rows.items()), 0.0), [t for t in batch if t.key not in rows]


def _batch_size(size: int, report: BatchReport) -> int:
    """So many cells as take ``BATCH_S``, approached by doubling at most."""
    each = max(report.seconds / len(report.errors), 1e-6)
    return max(1, min(round(BATCH_S / each), 2 * size, LARGEST_BATCH))


def _share(size: int, left: int, workers: int) -> int:
    """Smaller batches towards the end, so that all workers end together."""
    return max(1, min(size, left // (AHEAD * workers)))


def _time(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
