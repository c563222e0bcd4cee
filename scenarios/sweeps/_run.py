"""From a sweep to a folder of rows."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from servosight.models.core import check_path
from servosight.scenarios.sweeps.measure import LOADED, POOLS, CellWork, warm
from servosight.scenarios.sweeps.plan import Cell, Sweep, cells
from servosight.scenarios.sweeps.run import (
    Engine,
    InThisProcess,
    Store,
    Tally,
    Task,
    WatchLimits,
    dask_engine,
    drive,
    start_server,
)

OnProgress = Callable[[Tally, Sequence[str]], None]
OnStart = Callable[[Engine], None]


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    retry: bool = False,
    on_start: OnStart = lambda engine: None,
    on_progress: OnProgress = lambda tally, said: None,
    on_interrupt: Callable[[], None] = lambda: None,
    dashboard: bool = True,
) -> Tally:
    """Run the cells of ``sweep`` that ``folder`` has no row of; the rows are in it afterwards.

    ``workers`` processes (default: one for each core; 0: this process) or the workers of a
    ``scheduler``. With ``retry`` cells that have failed run again. An interruption at any moment
    loses what was being computed, nothing else; ``on_interrupt`` is called before the workers are
    closed, which takes longer than an interrupted process may have. Raises InputError for a folder
    of something else and for a scheduler that does not answer.
    """
    check_path(folder)
    store = Store(folder)
    with store.opened(_facts(sweep)):
        if retry:
            store.forget_failed()
        done = store.done()
        if len(done) < sweep.size and workers != 0 and scheduler is None:
            start_server(LOADED, POOLS)  # it imports while this process counts
        known = sum(cell.key in done for cell in cells(sweep)) if done else 0
        tally = Tally(sweep.size, earlier=known)
        if known == sweep.size:
            return tally
        todo = (_task(sweep, cell) for cell in cells(sweep) if cell.key not in done)
        work = CellWork.of(sweep)
        with _engine(work, store, sweep, workers, scheduler, dashboard) as engine:
            on_start(engine)
            try:
                drive(todo, engine, store, tally, on_progress)
            except KeyboardInterrupt:
                on_interrupt()
                raise
        store.tidy()
    return tally


def _facts(sweep: Sweep) -> dict[str, Any]:
    return {
        "name": sweep.name,
        "about": sweep.about,
        "made": sweep.made,
        "axes": list(sweep.design.names),
        "seeds": list(sweep.seeds),
        "cells": sweep.size,
        "recipe": sweep.recipe,
    }


def _task(sweep: Sweep, cell: Cell) -> Task:
    return Task(cell.key, cell, {**cell.settings, "seed": cell.seed, "made": sweep.made})


@contextmanager
def _engine(
    work: CellWork,
    store: Store,
    sweep: Sweep,
    workers: int | None,
    scheduler: str | None,
    dashboard: bool,
) -> Iterator[Engine]:
    count = os.cpu_count() or 1 if workers is None else workers
    if count == 0 and scheduler is None:
        yield InThisProcess(work, store.cells)
        return
    limits = WatchLimits(sweep.limits.seconds, sweep.limits.memory_mb)
    with dask_engine(
        work,
        store.cells.resolve(),
        limits,
        workers=count,
        scheduler=scheduler,
        warm=warm,
        environment=POOLS,
        loaded=LOADED,
        dashboard=dashboard,
    ) as engine:
        yield engine
