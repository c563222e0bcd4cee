"""Run the paper's tables and figures anew and put them into docs/paper.md.

`python benchmarks/paper` runs all parts, `python benchmarks/paper table-1 system` some of them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from . import actuator, fits, functions, system
from .page import put

PARTS: dict[str, Callable[[], str]] = {
    "table-1": functions.table_one,
    "table-1-peers": functions.table_one_peers,
    "rastrigin": functions.many_minima,
    "as-printed": functions.as_printed,
    "linear-fit": fits.linear,
    "traps": fits.traps,
    "system": system.figures,
    "conversion": actuator.conversion,
    "sine": actuator.what_a_sine_determines,
    "scatter": actuator.scatter,
    "video": actuator.through_the_video,
}


def main(names: list[str]) -> None:
    """Run the parts of these names, all where none is given."""
    unknown = set(names) - PARTS.keys()
    if unknown:
        sys.exit(f"no such part: {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    for name in names or PARTS:
        began = time.process_time()
        put(name, PARTS[name]())
        print(f"{name}: {time.process_time() - began:.1f} s of processor time", flush=True)
