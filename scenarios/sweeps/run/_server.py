"""The process that local workers are forked from, with all that they import loaded once."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from multiprocessing import forkserver


def start_server(modules: Sequence[str], environment: Sequence[str] = ()) -> None:
    """Start Python's fork server, which imports ``modules`` and what a worker consists of.

    Returns without waiting for it. Variables of ``environment`` are 1 in it and in its children.
    It runs until this process and its children have ended, and a second call changes nothing.
    Modules must not start threads.
    """
    forkserver.set_forkserver_preload(["distributed", *modules])
    # Without safe path, a file random.py in the working folder would be taken for Python's own.
    variables = {"PYTHONSAFEPATH": "1", "PYTHONHASHSEED": "0"} | dict.fromkeys(environment, "1")
    before = {name: os.environ.get(name) for name in variables}
    # Ctrl-C reaches all processes of a terminal; this one ends its workers in order.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    os.environ.update(variables)
    try:
        forkserver.ensure_running()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
