"""Threads of a benchmark: settings that libraries read once, when they are loaded."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

AS_COMMAND = {"OPENBLAS_NUM_THREADS": "1"}
"""As the command line has it."""


def restart_unless(settings: Mapping[str, str]) -> None:
    """Start the running script anew with these environment variables unless they are set so."""
    if not settings.items() <= os.environ.items():  # too late once numpy and numba are loaded
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **settings})
