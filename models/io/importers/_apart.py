"""Files that native parsers read, in a process of their own: a damaged one may kill its reader.

A format whose library is not one of servosight's own keeps to this way, too: its parser may need
much time or memory for a damaged file.
"""

from __future__ import annotations

import io
import json
import os
import stat
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, check_path
from servosight.models.io.importers import reader

LARGEST_FILE = 1 << 32
LONGEST_READ_S = 120.0
CUT_OFF = (
    "the end of the file is missing, and what is before it was read; copy it again if it can be"
)
"""The note on a log whose recorder was interrupted, or of which a copy was."""
_PROGRAM = f"import sys; from {reader.__name__} import main; sys.exit(main())"


@dataclass(frozen=True)
class Extract:
    """What a parser found of the columns that were asked for.

    ``columns`` (rows,) by name, ``times_s`` (rows,) of those that have stamps of their own, the
    ``names`` of all columns, and ``facts``: single numbers and texts. ``notes`` are sentences that
    the user should read. ``units`` are those of columns whose message is defined in that unit.
    """

    columns: dict[str, Array]
    names: tuple[str, ...]
    times_s: dict[str, Array] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    units: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Parser:
    """A format's parser: its module, what a file of it is called, and the library that it needs."""

    module: str
    kind: str
    library: str | None = None
    fix: str = "expected a whole file, so copy or save it again"


def extract(path: Path, parser: Parser, wanted: Sequence[str] = (), **options: Any) -> Extract:
    """``wanted`` columns of a file, or of a folder's files; all where none is named.

    The module's function ``extract(path, wanted, **options)`` makes them in the other process.
    InputError where the file cannot be read, or the library is missing, or as the function says.
    """
    if parser.library is not None and find_spec(parser.library) is None:
        raise InputError(
            f"{path}: is {parser.kind}, expected {parser.library} to be installed, which reads it; "
            f"run pip install 'servosight[logs]'"
        )
    _check_files(path, parser.kind)
    asked = {"module": parser.module, "path": str(path.resolve()), "wanted": list(wanted)}
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROGRAM],
            input=json.dumps({**asked, "options": options}).encode(),
            capture_output=True,
            timeout=LONGEST_READ_S,
        )
    except subprocess.TimeoutExpired:
        why = f"it takes more than {LONGEST_READ_S:g} s"
    else:
        if done.returncode == 0:
            return _unpacked(done.stdout)
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
        if done.returncode == reader.REFUSED:
            raise InputError(f"{path}: {lines[-1]}")
        why = lines[-1][:120] if lines and done.returncode > 0 else "its parser broke down"
    raise InputError(f"{path}: cannot be read as {parser.kind} ({why}); {parser.fix}")


def _check_files(path: Path, kind: str) -> None:
    """Refuse what is no regular file or folder of them, or too large."""
    check_path(path)
    total = 0
    for place in [path, *path.rglob("*")] if path.is_dir() else [path]:
        state = os.stat(place)
        if not stat.S_ISREG(state.st_mode) and not stat.S_ISDIR(state.st_mode):
            raise InputError(f"{place}: is no file, expected {kind}; name the file itself")
        total += state.st_size if place.suffix.lower() not in (".mp4", ".mkv", ".png") else 0
    if total > LARGEST_FILE:
        raise InputError(
            f"{path}: has more than {LARGEST_FILE:,} bytes, the most that is read; expected "
            f"{kind} of at most that, so cut it into parts"
        )


def _unpacked(content: bytes) -> Extract:
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        index = json.loads(bytes(arrays[reader.INDEX]))
        columns = {name: arrays[f"column_{n}"] for n, name in enumerate(index["columns"])}
        times_s = {name: arrays[f"time_{n}"] for n, name in enumerate(index["times"])}
    names, notes = tuple(index["names"]), tuple(index["notes"])
    return Extract(columns, names, times_s, index["facts"], notes, index["units"])
