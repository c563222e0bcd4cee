"""Local workers on Dask: what a cell that never ends leaves of them, and of the other cells."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import pytest

from servosight.scenarios.sweeps.run import Store, Tally, Task, WatchLimits, dask_engine, drive

SLEEPS, HOLDS, COUNT = 3, 8, 12


def work(number: int) -> dict[str, Any]:
    """A row; two cells never end, one of them in native code in which no Python thread runs."""
    if number == SLEEPS:
        time.sleep(3600.0)
    if number == HOLDS:
        sum(range(10**15))
    return {"pid": os.getpid(), "threads": os.environ.get("NUMBA_NUM_THREADS", "")}


def no_warming() -> None:
    """There is nothing to compile."""


def test_workers_that_hang_are_started_anew_and_the_sweep_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    import test_local_cluster as by_name  # under which the workers import it

    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)  # the workers have it, not this process
    before = dict(os.environ)
    store, tally = Store(tmp_path / "s"), Tally(COUNT)
    todo = (Task(f"{n:032x}", n, {"n": n, "made": "m"}) for n in range(COUNT))
    with (
        store.opened({}),
        dask_engine(
            by_name.work,
            store.cells,
            WatchLimits(seconds=0.5, grace_s=0.5),
            workers=2,
            scheduler=None,
            warm=by_name.no_warming,
            environment=["NUMBA_NUM_THREADS"],
            dashboard=False,
        ) as engine,
    ):
        drive(todo, engine, store, tally, lambda tally, said: None)
    frame = store.frame().sort("n")
    assert frame["n"].to_list() == list(range(COUNT))
    failed = frame.filter(frame["status"] == "failed")
    assert failed["n"].to_list() == [SLEEPS, HOLDS]
    assert failed["error"][0] == "time limit: the cell took more than 0.5 s"
    assert "native code crashed or exceeded the time limit" in failed["error"][1]
    for name in ("PYTHONSAFEPATH", "NUMBA_NUM_THREADS"):  # set in the workers alone
        assert os.environ.get(name) == before.get(name)
    assert frame["threads"].drop_nulls().unique().to_list() == ["1"]
