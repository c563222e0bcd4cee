"""Prefetch: the next pictures are decoded while this one is measured."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def prefetch(source: Iterator[T], count: int) -> Iterator[T]:
    """The same items in the same order, up to ``count`` of them made early by a second thread.

    What the source raises is raised where its item would have come. Worth it where the source
    lets go of the interpreter, as FFmpeg's decoders do.
    """
    end = object()
    with ThreadPoolExecutor(1) as pool:
        coming = deque(pool.submit(next, source, end) for _ in range(count))
        while (item := coming.popleft().result()) is not end:
            coming.append(pool.submit(next, source, end))
            yield item  # type: ignore[misc]  # the type does not exclude next's default
