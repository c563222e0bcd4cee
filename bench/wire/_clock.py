"""Two ways in which time passes on a wire: only while somebody waits, or in real time."""

from __future__ import annotations

import select
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np

from servosight.bench.host_clock import HOST

_OFTEN_S = 1e-3
_PATIENCE_S = 5.0


class Pumped(Protocol):
    """What a clock drives: a wire, or anything else that has events in time."""

    def pump(self, now_s: float) -> float:
        """Do what is due by now; return the time of the next event, inf without one."""


class VirtualClock:
    """A ``Clock`` whose time passes only while somebody waits, event by event.

    A driver, its serial port and the stand-in at the other end then run in one thread, the same way
    every time, and a time-out costs nothing. ``late_s`` is the mean by which a wait without a file
    ends late, as it does on a busy computer (exponentially distributed, from ``seed``).
    """

    def __init__(self, wires: Sequence[Pumped], late_s: float = 0.0, seed: int = 0) -> None:
        """Start at 1000 s."""
        self._wires = wires
        self._time_s = 1000.0
        self._late_s = late_s
        self._random = np.random.default_rng(seed)

    def now(self) -> float:
        """The time in s."""
        return self._time_s

    def wait(self, until_s: float, fd: int | None = None) -> bool:
        """Let time pass until ``until_s``, or until ``fd`` can be read."""
        if fd is None and self._late_s:
            until_s += float(self._random.exponential(self._late_s))
        while True:
            due = min([wire.pump(self._time_s) for wire in self._wires], default=until_s)
            if fd is not None and select.select([fd], [], [], 0.0)[0]:
                return True
            if self._time_s >= until_s:
                return False
            self._time_s = max(self._time_s, min(due, until_s))

    def wait_for(self, event: threading.Event, until_s: float) -> bool:
        """Wait for another thread, whose work takes no time by this clock.

        Where the event is not there after five seconds of real time, it may need this clock's time
        to pass, which it then does until ``until_s``.
        """
        if not event.wait(_PATIENCE_S):
            self.wait(until_s)
        return event.is_set()


@contextmanager
def serving(wire: Pumped) -> Iterator[None]:
    """Serve a wire in real time, on a thread, for the body of a ``with``."""
    stop = threading.Event()

    def serve() -> None:
        while not stop.is_set():
            due = wire.pump(HOST.now())
            far = getattr(wire, "far", -1)
            left = min(_OFTEN_S, max(0.0, due - HOST.now()))
            if far >= 0:
                select.select([far], [], [], left)
            else:
                stop.wait(left)

    thread = threading.Thread(target=serve, name="servosight wire", daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
