"""Load and compile once on a node what all its cells use."""

from __future__ import annotations

POOLS = (
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "POLARS_MAX_THREADS",
)
"""Variables that hold the thread pools of libraries to one thread, read when they are loaded."""

LOADED = (
    "servosight.scenarios.produce",
    "servosight.identify.fit",
    "servosight.diagnose",
    "servosight.scenarios.sweeps.measure",
)
"""What a cell imports; a worker begins with it."""


def warm() -> None:
    """Compile the kernel into the node's cache, unless it stands there already."""
    from servosight.models.plant.warmup import main

    main()
