"""Read a log in a process of its own: a damaged file may kill the process that reads it.

Which file and which columns comes in as JSON on standard input; the arrays leave as an ``.npz`` on
standard output. Parsers trust the sizes that a file states, so memory is limited, and what goes
wrong is one line on standard error.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from pathlib import Path

INDEX = "index"
REFUSED = 3
"""The exit code for a file that was read and is none to import: the line says all but its name."""
LARGEST_MEMORY = 4 << 30
"""Bytes of address space, of which the libraries take up to 1 GB."""


def main() -> int:
    """Read standard input; returns the exit code."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (LARGEST_MEMORY, LARGEST_MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, ValueError, OSError):
        pass  # no limits on this system, or lower ones already
    import numpy as np

    from servosight.models.base import InputError

    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a parser prints is no part of the answer
    sys.stdout = sys.stderr
    try:
        asked = json.load(sys.stdin)
        module = import_module(asked["module"])
        found = module.extract(Path(asked["path"]), asked["wanted"], **asked["options"])
        index = {
            "columns": list(found.columns),
            "times": list(found.times_s),
            "names": list(found.names),
            "facts": found.facts,
            "notes": list(found.notes),
            "units": found.units,
        }
        arrays = {INDEX: np.frombuffer(json.dumps(index).encode(), dtype=np.uint8)}
        arrays |= {f"column_{n}": one for n, one in enumerate(found.columns.values())}
        arrays |= {f"time_{n}": one for n, one in enumerate(found.times_s.values())}
        np.savez(answer, allow_pickle=False, **arrays)
        answer.close()
    except InputError as error:
        print(error, file=sys.stderr)
        return REFUSED
    except Exception as error:  # a parser raises whatever broken bytes lead it to
        print(" ".join(str(error).split()) or type(error).__name__, file=sys.stderr)
        return 1
    return 0
