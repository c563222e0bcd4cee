"""What a worker does with a batch of cells: each row is on the disk before the next cell begins."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from servosight.models.core import plain
from servosight.scenarios.sweeps.run._watch import WatchLimits, watched

Row = dict[str, Any]
Work = Callable[[Any], Row]

DONE, FAILED = "done", "failed"


@dataclass(frozen=True)
class Task:
    """One cell to run: ``key`` names its result, ``known`` are columns that it has in any case."""

    key: str
    argument: Any
    known: Row = field(default_factory=dict)


@dataclass(frozen=True)
class BatchReport:
    """What became of a batch: each cell's key with its error, empty where it succeeded."""

    errors: tuple[tuple[str, str], ...]
    seconds: float


def run_batch(work: Work, tasks: Sequence[Task], folder: str, limits: WatchLimits) -> BatchReport:
    """Run the cells that have no row in ``folder`` yet.

    A batch may run twice, on two workers at once: the rows are the same, and each is written aside
    and renamed. Where a limit ends the process, the cell's row says so first.
    """
    place = Path(folder)
    began = time.perf_counter()
    errors = []
    for task in tasks:
        path = row_path(place, task.key)
        if not path.exists():
            with watched(limits, lambda why, task=task: _give_up(place, task, why)):  # type: ignore[misc]
                row = _ran(work, task)
            write_row(place, task.key, row)
        else:
            row = json.loads(path.read_text(encoding="utf-8"))
        errors.append((task.key, str(row["error"] or "")))
    return BatchReport(tuple(errors), time.perf_counter() - began)


def failed_row(task: Task, why: str) -> Row:
    """The row of a cell that has no result."""
    return {"cell": task.key, **task.known, "status": FAILED, "error": why}


def row_path(folder: Path, key: str) -> Path:
    """Where the row of a cell stands until it joins a part."""
    return folder / f"{key}.json"


def write_row(folder: Path, key: str, row: Row) -> None:
    """Write a row completely or not at all."""
    path = row_path(folder, key)
    aside = path.with_suffix(f".{os.getpid()}-{os.urandom(4).hex()}")
    aside.write_text(json.dumps(plain(row), ensure_ascii=False, allow_nan=False), encoding="utf-8")
    aside.replace(path)


def _ran(work: Work, task: Task) -> Row:
    began = time.perf_counter()
    try:
        found = work(task.argument)
    except Exception as error:  # whatever it is, it is this cell's, and the sweep goes on
        name = type(error).__name__
        row = failed_row(task, " ".join(f"{name}: {error}".split()))
    else:
        # What is known of a cell is not changed by its result.
        row = {**found, "cell": task.key, **task.known, "status": DONE, "error": None}
    return {**row, "seconds": time.perf_counter() - began}


def _give_up(folder: Path, task: Task, why: str) -> None:
    write_row(folder, task.key, {**failed_row(task, why), "seconds": None})
