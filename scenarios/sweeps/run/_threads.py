"""Workers that somebody else has started: their libraries are held to one thread as well."""

from __future__ import annotations

import os
from collections.abc import Sequence

from distributed import Worker, WorkerPlugin

NAME = "servosight-one-thread"


class OneThread(WorkerPlugin):  # type: ignore[misc]
    """Sets variables to 1 in each worker, also in those that come later.

    Libraries read them when they are loaded, which is with a worker's first cell. A variable that
    the worker was started with stays.
    """

    def __init__(self, environment: Sequence[str]) -> None:
        self.environment = tuple(environment)

    def setup(self, worker: Worker) -> None:
        """Called in the worker."""
        for name in self.environment:
            os.environ.setdefault(name, "1")
