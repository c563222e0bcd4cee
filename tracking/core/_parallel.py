"""Work on independent items in threads, with results that do not depend on their number."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import TypeVar

import numba
import numpy as np

S = TypeVar("S")
T = TypeVar("T")

_CHUNKS = 4


def most_threads() -> int:
    """As many threads as numba may use: one for each core, or ``NUMBA_NUM_THREADS``, which the
    workers of a sweep set to one."""
    allowed: int = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]  # set at import
    return allowed


def threaded(function: Callable[[S], T], items: Sequence[S]) -> list[T]:
    """The function of each item, in order.

    In at most ``most_threads``. Worth it where the function lets go of the interpreter, as compiled
    kernels and OpenCV do.

    >>> threaded(lambda number: number**2, [1, 2, 3])
    [1, 4, 9]
    """
    allowed = most_threads()
    threads = min(allowed, len(items))
    if threads < 2:
        return [function(item) for item in items]
    waiting = deque(enumerate(items))
    results: dict[int, T] = {}

    def work() -> None:
        while True:
            try:
                place, item = waiting.popleft()
            except IndexError:
                return
            results[place] = function(item)

    helping = [_pool(allowed).submit(work) for _ in range(threads - 1)]
    try:
        work()
    finally:
        waiting.clear()
        # One that has not begun never needs to: so a function may itself work in threads.
        begun = [one for one in helping if not one.cancel()]
        wait(begun)
    for one in begun:
        one.result()
    return [results[place] for place in range(len(items))]


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that stay: to start them anew takes as long as a small item."""
    return ThreadPoolExecutor(threads)


def chunks(count: int) -> list[range]:
    """``count`` numbers in at most four ranges of about equal length, whatever the threads are:
    sums over chunks are then the same everywhere.

    >>> chunks(6)
    [range(0, 2), range(2, 4), range(4, 5), range(5, 6)]
    """
    parts = np.array_split(np.arange(count), min(_CHUNKS, max(count, 1)))
    return [range(int(part[0]), int(part[-1]) + 1) for part in parts if part.size]
