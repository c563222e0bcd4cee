"""A process that runs cases one after the other and reports how each ended.

It reads a case a line on standard input and writes a line for each to standard output. The folder
of valid inputs is its argument; each case gets a copy of it as its working folder.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

ADDRESS_SPACE = 8 << 30
"""A case that asks for more ends in a MemoryError, before the machine suffers."""


def main() -> None:
    """Run cases until standard input ends."""
    valid = Path(sys.argv[1])
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    nowhere = os.open(os.devnull, os.O_RDWR)
    requests = os.fdopen(os.dup(0), "r")
    for descriptor in (0, 1, 2):  # what native code says is not for the terminal
        os.dup2(nowhere, descriptor)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    warnings.simplefilter("ignore")
    sys.setswitchinterval(0.05)
    sys.dont_write_bytecode = True  # Python keeps what a full disk has cut off
    with tempfile.TemporaryDirectory() as place:
        for number, request in enumerate(requests):
            folder = Path(place) / str(number)
            shutil.copytree(valid, folder)
            print(json.dumps(run(json.loads(request), folder)), file=replies)
            os.chdir(place)
            shutil.rmtree(folder, ignore_errors=True)


def run(case: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Run one case in ``folder``; its exit code, time, memory, and what it said."""
    from servosight.app.main import main as servosight

    os.chdir(folder)
    if case["file"] is not None:
        Path(case["file"]).write_bytes(base64.b64decode(case["data"]))
    said = io.StringIO()
    Path("/proc/self/clear_refs").write_text("5")  # peak memory counts from here
    began = time.perf_counter()
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    if case["largest_file"] is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (case["largest_file"], most))
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            code: Any = servosight(case["line"])
    except BaseException as error:
        code = f"{type(error).__name__}: {error}"
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    hidden = [path.name for path in folder.rglob(".*")]
    return {
        "code": code,
        "seconds": time.perf_counter() - began,
        "bytes": _peak(),
        "said": said.getvalue()[-20_000:],
        "hidden": hidden,
    }


def _peak() -> int:
    """Largest resident memory [bytes] since the counter was reset."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    return 0


if __name__ == "__main__":
    main()
