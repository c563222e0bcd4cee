"""A cell's limits of time and memory: the worker that exceeds one writes so, and ends.

A computation in native code cannot be interrupted from within its process. A thread watches, and
the process ends as a whole; whoever started the worker starts it anew. Where native code holds the
interpreter's lock, no Python thread runs: then Python's own watchdog, a thread in C, ends the
process some seconds later, and the driver writes the row.
"""

from __future__ import annotations

import faulthandler
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

INTERVAL_S = 0.2
EXIT_CODE = 76
_STATM = Path("/proc/self/statm")


@dataclass(frozen=True)
class WatchLimits:
    """What a cell may take before it is given up; None where nothing is limited.

    ``grace_s`` after its time a cell that lets no Python thread run is ended without a row.
    """

    seconds: float | None = None
    memory_mb: float | None = None
    grace_s: float = 10.0


@contextmanager
def watched(limits: WatchLimits, give_up: Callable[[str], None]) -> Iterator[None]:
    """Call ``give_up`` with the reason and end the process when the block exceeds a limit."""
    if limits.seconds is None and limits.memory_mb is None:
        yield
        return
    over = threading.Event()
    threading.Thread(target=_watch, args=(limits, give_up, over), daemon=True).start()
    with open(os.devnull, "w") as nowhere:  # the watchdog prints where the cell was
        if limits.seconds is not None:
            end_s = limits.seconds + limits.grace_s
            faulthandler.dump_traceback_later(end_s, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
            over.set()


def _watch(limits: WatchLimits, give_up: Callable[[str], None], over: threading.Event) -> None:
    began = time.monotonic()
    while not over.wait(INTERVAL_S):
        why = ""
        if limits.seconds is not None and time.monotonic() - began > limits.seconds:
            why = f"time limit: the cell took more than {limits.seconds:g} s"
        elif limits.memory_mb is not None and resident_mb() > limits.memory_mb:
            why = f"memory limit: the worker held more than {limits.memory_mb:g} MB"
        if why and not over.is_set():
            give_up(why)
            os._exit(EXIT_CODE)


def resident_mb() -> float:
    """Resident memory of this process [MB]; 0 where the system does not say."""
    try:
        pages = int(_STATM.read_text().split()[1])
    except (OSError, ValueError, IndexError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
