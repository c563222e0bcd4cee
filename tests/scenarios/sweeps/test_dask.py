"""Cells on Dask: a scheduler and two workers started by hand, one of which is killed at work."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from servosight.models.core import InputError
from servosight.scenarios.sweeps.run import (
    InThisProcess,
    Store,
    Tally,
    Task,
    WatchLimits,
    dask_engine,
    drive,
)


def work(number: int) -> dict[str, Any]:
    """A row; on a worker 7 kills it, once."""
    marker = Path(os.environ.get("SWEEP_TEST", "")) / "killed"
    if number == 7 and "SWEEP_TEST" in os.environ and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": number**2, "threads": os.environ.get("NUMBA_NUM_THREADS", "")}


def no_warming() -> None:
    """There is nothing to compile."""


def tasks() -> Iterator[Task]:
    return (Task(f"{n:032x}", n, {"n": n, "made": "m"}) for n in range(24))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """A scheduler and two workers on loopback, as a user starts them; the scheduler's file."""
    place = tmp_path_factory.mktemp("cluster")
    file = place / "scheduler.json"
    environment = {
        **os.environ,
        "SWEEP_TEST": str(place),
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path]),
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    }
    environment.pop("NUMBA_NUM_THREADS", None)
    shared = ["--scheduler-file", str(file), "--no-dashboard"]
    local = ["--host", "127.0.0.1", "--port", "0"]
    worker = ["worker", *shared, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny"]
    words = [["scheduler", *shared, *local], worker, worker]
    started = [
        subprocess.Popen(
            [sys.executable, "-m", "dask", *line],
            cwd=place,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE if line[0] == "scheduler" else subprocess.DEVNULL,
            text=True,
        )
        for line in words
    ]
    spoken = started[0].stderr
    assert spoken is not None
    try:
        next(line for line in spoken if "Scheduler at" in line)
        while not file.is_file() or not file.read_text().endswith("}"):  # it writes this next
            time.sleep(0.01)
        yield str(file), place
    finally:
        spoken.close()
        for process in reversed(started):
            process.kill()
        for process in started:
            process.wait()


def test_same_rows_by_workers_started_by_hand_one_of_them_killed(
    cluster: tuple[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, place = cluster
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    import test_dask  # by the name under which the workers import it

    store = Store(tmp_path / "s")
    tally = Tally(24)
    with (
        store.opened({}),
        dask_engine(
            test_dask.work,
            store.cells,
            WatchLimits(seconds=60.0),
            workers=2,
            scheduler=file,
            warm=test_dask.no_warming,
            environment=["NUMBA_NUM_THREADS"],
        ) as engine,
    ):
        drive(tasks(), engine, store, tally, lambda tally, said: None)
        store.tidy()
    assert (place / "killed").exists()
    frame = store.frame().sort("n")
    assert frame["n"].to_list() == list(range(24))  # nothing lost, nothing twice
    assert frame["threads"].unique().to_list() == ["1"]
    alone = Store(tmp_path / "alone")
    with alone.opened({}):
        drive(tasks(), InThisProcess(work, alone.cells), alone, Tally(24), lambda t, s: None)
    kept = ["n", "square", "cell", "made", "status", "error"]
    one, other = (each.frame().sort("n").select(kept) for each in (store, alone))
    assert one.equals(other)


def test_no_scheduler_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("servosight.scenarios.sweeps.run._dask.CONNECT_S", 0.2)
    with (
        pytest.raises(InputError, match="no scheduler answers"),
        dask_engine(
            work,
            tmp_path,
            WatchLimits(),
            workers=1,
            scheduler="tcp://127.0.0.1:9",
            warm=no_warming,
        ),
    ):
        pass
