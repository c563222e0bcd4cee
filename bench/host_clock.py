"""The host's clock, and waiting on it: everything on the bench that waits does it here.

A driver and a run take a ``Clock``; the stand-ins bring one whose time passes only while somebody
waits, so that a test of a time-out takes no time.
"""

from __future__ import annotations

import select
import threading
import time
from typing import Protocol


class Clock(Protocol):
    """A monotonic time in s, and waiting until a time or until a file has bytes."""

    def now(self) -> float:
        """The time in s."""

    def wait(self, until_s: float, fd: int | None = None) -> bool:
        """Wait until a time, or until ``fd`` can be read; True in the second case."""

    def wait_for(self, event: threading.Event, until_s: float) -> bool:
        """Wait until a time, or until another thread has set ``event``; True in the second case."""


class HostClock:
    """CLOCK_MONOTONIC, with which V4L2 stamps its frames as well."""

    def now(self) -> float:
        """The time in s."""
        return time.monotonic()

    def wait(self, until_s: float, fd: int | None = None) -> bool:
        """Wait until a time, or until ``fd`` can be read; True in the second case."""
        left = max(0.0, until_s - time.monotonic())
        if fd is None:
            time.sleep(left)
            return False
        return bool(select.select([fd], [], [], left)[0])

    def wait_for(self, event: threading.Event, until_s: float) -> bool:
        """Wait until a time, or until another thread has set ``event``; True in the second case."""
        return event.wait(max(0.0, until_s - time.monotonic()))


HOST = HostClock()
