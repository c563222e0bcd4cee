"""Load and compile once on a node what all its cells use."""

from __future__ import annotations

import os
import sys

POOLS = (
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "POLARS_MAX_THREADS",
)
"""Variables that hold the thread pools of libraries to one thread, read when they are loaded."""


def warm() -> None:
    """Compile the kernel into the node's cache, unless it stands there already.

    A worker that was started by hand gets one thread for each library's pool.
    """
    if "numba" not in sys.modules:  # afterwards its number of threads stays
        for pool in POOLS:
            os.environ.setdefault(pool, "1")
    from servosight.models.plant.warmup import main

    main()
