"""The temporary folder of an unpacked FMU: locked while in use, removed at the next start if not.

A program that is killed cannot tidy up. The lock ends with its process, whatever ended that; so a
folder whose lock is free belongs to nobody.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

# Without such locks folders of killed programs stay where they are.
fcntl: Any = import_module("fcntl") if os.name == "posix" else None
PREFIX = "servosight-fmu-"
_LOCK = "lock"
_UNLOCKED_S = 3600.0
"""A folder without any lock may be one that is just being made, but not for so long."""


@contextmanager
def own_folder() -> Iterator[Path]:
    """An empty temporary folder, removed at the end; those of killed programs are removed first."""
    _remove_stale(Path(tempfile.gettempdir()))
    with tempfile.TemporaryDirectory(prefix=PREFIX) as folder:
        new = Path(folder) / f"{_LOCK}-new"
        lock = os.open(new, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            if fcntl is not None:
                fcntl.flock(lock, fcntl.LOCK_EX)
            new.rename(Path(folder) / _LOCK)  # nobody sees it before it is locked
            files = Path(folder) / "files"
            files.mkdir()
            yield files
        finally:
            os.close(lock)


def _remove_stale(parent: Path) -> None:
    if fcntl is None:
        return
    for folder in parent.glob(f"{PREFIX}*"):
        try:
            known = folder.lstat()
            if known.st_uid == os.getuid() and not folder.is_symlink() and _free(folder, known):
                shutil.rmtree(folder, ignore_errors=True)
        except OSError:  # gone meanwhile, or not to be read
            continue


def _free(folder: Path, known: os.stat_result) -> bool:
    try:
        lock = os.open(folder / _LOCK, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return time.time() - known.st_mtime > _UNLOCKED_S
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    finally:
        os.close(lock)
    return True
