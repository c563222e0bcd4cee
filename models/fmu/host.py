"""The process that loads and runs an FMU: messages in on standard input, out on standard output.

An FMU is native code. Here it may crash, hang or take memory without end; the program that started
this process reads the answer, or says in one sentence what became of it.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import Any, BinaryIO

from servosight.models.fmu._wire import packed, received

LARGEST_FILE = 1 << 26
"""Bytes of a file that an FMU may write."""
_LOOK_S = 0.5


def main(memory_bytes: int) -> int:
    """Serve until standard input ends; returns the exit code."""
    _limit(memory_bytes)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what an FMU prints is no part of an answer
    sys.stdout = sys.stderr
    asked = os.fdopen(os.dup(0), "rb")
    served: Any = None
    while True:
        try:
            table, arrays = received(lambda count: _exactly(asked, count))
        except EOFError:
            return 0
        try:
            from servosight.models.fmu._session import Session

            if served is None:
                served = Session(**table["open"])
                answer = packed({"description": served.description})
            else:
                values, errors = served.run(table, arrays)
                answer = packed({"errors": errors}, values)
        except MemoryError:
            answer = packed({"error": "it takes more memory than it may have"})
        except Exception as error:  # whatever a foreign FMU leads fmpy to
            said = " ".join(str(error).split())[:300] or type(error).__name__
            answer = packed({"error": said})
        answers.write(answer)
        answers.flush()


def _end_with(parent: int) -> None:
    """End the process where the program that started it is gone, also within an endless step."""
    while os.getppid() == parent:
        time.sleep(_LOOK_S)
    os._exit(1)


def _limit(memory_bytes: int) -> None:
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
    except (ImportError, ValueError, OSError):
        pass  # no limits on this system, or lower ones already


def _exactly(stream: BinaryIO, count: int) -> bytes:
    data = stream.read(count)
    if len(data) < count:
        raise EOFError
    return data
