"""Read a MATLAB file in a process of its own: a damaged one may kill the process that reads it.

The file comes in on standard input; its numeric arrays leave as an ``.npz`` on standard output.
scipy trusts the sizes that the file states, so memory is limited, and what goes wrong is one line
on standard error.
"""

from __future__ import annotations

import io
import sys

PREFIX = "variable_"
LARGEST_MEMORY = 3 << 30
"""Bytes of address space, of which numpy and scipy take about 0.4 GB."""


def main() -> int:
    """Read standard input; returns the exit code."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (LARGEST_MEMORY, LARGEST_MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, ValueError, OSError):
        pass  # no limits on this system, or lower ones already
    import numpy as np
    from scipy.io import loadmat

    try:
        content = loadmat(io.BytesIO(sys.stdin.buffer.read()))
        arrays = {
            PREFIX + name: value  # as `file` is a name of np.savez itself
            for name, value in content.items()
            if isinstance(value, np.ndarray) and value.dtype.kind in "iuf"
        }
        np.savez(sys.stdout.buffer, allow_pickle=False, **arrays)
    except Exception as error:  # the parser raises whatever broken bytes lead it to
        print(" ".join(str(error).split()) or type(error).__name__, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
