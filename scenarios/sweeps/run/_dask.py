"""Batches on Dask distributed: a local cluster on loopback, or a scheduler that is there already.

The scheduler decides who runs what; it is not trusted with results. One thread a worker: the
libraries below hold locks, and numba's cache is not made for two compilers in one process.

Local workers are forked from a server process that has imported what cells use (Python's method
forkserver): all of them together cost one import, and one that is lost is back at once. The server
imports while this process does so itself. It neither runs a kernel nor starts a thread, as locks
and OpenMP do not survive a fork.
"""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from servosight.models.core import InputError
from servosight.scenarios.sweeps.run._batch import Task, Work, run_batch
from servosight.scenarios.sweeps.run._engine import Outcome
from servosight.scenarios.sweeps.run._server import start_server
from servosight.scenarios.sweeps.run._watch import WatchLimits

LOOPBACK = "127.0.0.1"
CONNECT_S = 10.0
WORKERS_S = 60.0
START_S = 600.0
"""A worker that is started anew may take so long on a crowded machine."""
SETTINGS = {
    "distributed.worker.multiprocessing-method": "forkserver",
    "distributed.scheduler.allowed-failures": 0,
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.comm.timeouts.connect": CONNECT_S,
    # A cell may hold the interpreter for as long as its limit, without a heartbeat.
    "distributed.scheduler.worker-ttl": None,
    # What watches and moves data; there are none, and it costs time in every process.
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing": False,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.gil.enabled": False,
}


class OnDask:
    """Batches as futures of a client."""

    def __init__(self, client: Any, work: Work, folder: Path, limits: WatchLimits) -> None:
        from distributed import as_completed

        self._client, self._folder, self._limits = client, str(folder), limits
        self._work = work  # sent with each batch: what is scattered dies with its workers
        self._done = as_completed(loop=client.loop)
        self._batches: dict[str, tuple[Task, ...]] = {}
        self._number = 0
        self.workers = max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        self.dashboard: str = client.dashboard_link

    def submit(self, tasks: Sequence[Task]) -> None:
        """Send a batch to the scheduler."""
        self._number += 1
        future = self._client.submit(
            run_batch,
            self._work,
            tuple(tasks),
            self._folder,
            self._limits,
            key=f"cells-{self._number}-{tasks[0].key[:8]}",
            pure=False,
        )
        self._batches[future.key] = tuple(tasks)
        self._done.add(future)

    def wait(self) -> Outcome:
        """The next batch; None in place of a report where its worker was lost."""
        future = next(self._done)
        tasks = self._batches.pop(future.key)
        try:
            return tasks, future.result()
        except _losses():
            if self._client.status != "running":
                raise InputError(
                    "the scheduler was lost, expected it to run until the sweep ends; start it "
                    "again and repeat the command, which goes on where it stopped"
                ) from None
            return tasks, None
        finally:
            future.release()


def _losses() -> tuple[type[BaseException], ...]:
    """What a future raises when it is not its function that failed."""
    from distributed import CancelledError
    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    return KilledWorker, CancelledError, FutureCancelledError, CommClosedError


@contextmanager
def dask_engine(
    work: Work,
    folder: Path,
    limits: WatchLimits,
    *,
    workers: int,
    scheduler: str | None,
    warm: Callable[[], None],
    environment: Sequence[str] = (),
    loaded: Sequence[str] = (),
    dashboard: bool = True,
) -> Iterator[OnDask]:
    """An engine on ``workers`` local processes, or on the workers of ``scheduler``.

    ``scheduler`` is an address such as tcp://10.0.0.1:8786, or the scheduler's file. ``warm`` runs
    first, once on each node. Local workers begin with the modules ``loaded``. Variables of
    ``environment`` are 1 in workers; those of a ``scheduler`` may have been started with another
    value. Raises InputError where no scheduler answers or it has no workers.
    """
    if not scheduler:
        start_server(loaded, environment)
    import dask
    import distributed  # noqa: F401, it brings the defaults of its settings

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with dask.config.set(SETTINGS), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cluster = None if scheduler else _local(workers, environment, dashboard)
        try:
            client: Any = _client(scheduler, cluster)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(
                f"--scheduler {scheduler}: no scheduler answers ({error}), expected an address "
                f"such as tcp://127.0.0.1:8786 or a scheduler file; start `dask scheduler` first"
            ) from None
        try:
            if scheduler:
                _hold_threads(client, environment)
            _warm_nodes(client, warm, str(scheduler))
            yield OnDask(client, work, folder, limits)
        finally:
            client.close(timeout=2)
            if cluster is not None:
                cluster.close(timeout=5)


def _client(scheduler: str | None, cluster: Any) -> Any:
    from distributed import Client

    given = _address(scheduler) if scheduler else {"address": cluster}
    return Client(**given, set_as_default=False)


def _address(scheduler: str) -> dict[str, Any]:
    key = "scheduler_file" if Path(scheduler).is_file() else "address"
    return {key: scheduler, "timeout": CONNECT_S}


def _local(workers: int, environment: Sequence[str], dashboard: bool) -> Any:
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host=LOOPBACK,
        dashboard_address=f"{LOOPBACK}:0" if dashboard else None,
        worker_dashboard_address=None,
        memory_limit=0,  # a cell's own limit holds
        silence_logs=logging.CRITICAL,
        death_timeout=START_S,
        env={**os.environ, **dict.fromkeys(environment, "1")},
    )


def _hold_threads(client: Any, environment: Sequence[str]) -> None:
    from servosight.scenarios.sweeps.run._threads import NAME, OneThread

    client.register_plugin(OneThread(environment), name=NAME)


def _warm_nodes(client: Any, warm: Callable[[], None], scheduler: str) -> None:
    """Run ``warm`` on one worker of each node, so that no two compile the same kernel at once."""
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError:
        raise InputError(
            f"--scheduler {scheduler}: the scheduler has no workers, expected at least one; start "
            f"`dask worker {scheduler} --nthreads 1` first"
        ) from None
    known = client.scheduler_info(n_workers=-1)["workers"]
    crowded = [address for address, one in known.items() if one["nthreads"] != 1]
    if crowded:
        raise InputError(
            f"--scheduler {scheduler}: worker {crowded[0]} has {known[crowded[0]]['nthreads']} "
            f"threads, expected one; start workers with --nthreads 1 and more --nworkers"
        )
    nodes = {one["host"]: address for address, one in known.items()}
    client.run(warm, workers=sorted(nodes.values()))
