"""How many threads linear algebra has while a verb works."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def one_algebra_thread(verb: Callable[P, R]) -> Callable[P, R]:
    """``verb`` with linear algebra in one thread, as the command line has it.

    Simulations and pictures take all cores already: a second pool that waits for work slows them
    twofold. And sums over several threads are rounded otherwise, so that a long search may end
    elsewhere than the command line's.
    """

    @wraps(verb)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        import numpy as np  # noqa: F401, its library must be there to be limited
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return verb(*args, **kwargs)

    return limited
