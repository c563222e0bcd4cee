"""Temporary files and folders that a killed run does not leave for good.

Each lies beside what it will become, carries the process's number in its name, and is locked by the
process that made it. The lock ends with the process, however that ends: whoever writes into the
same folder next removes those that no process holds any more.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
from pathlib import Path

_NAME = re.compile(r"\..*\.servosight-\d+-[0-9a-f]{8}(\.\w+)?")
_LONGEST = 40  # characters of the target's name; a file system allows 255 bytes in all
_ATTEMPTS = 100
_held: dict[Path, int] = {}
_swept: set[Path] = set()


def temporary_file(target: Path) -> Path:
    """An empty, locked file beside ``target``, with its ending; OSError where that cannot be."""
    return _claim(target, os.O_CREAT | os.O_EXCL | os.O_RDWR)


def temporary_folder(target: Path) -> Path:
    """An empty, locked folder beside ``target``; OSError where that cannot be."""
    return _claim(target, os.O_RDONLY | os.O_DIRECTORY)


def discard(path: Path) -> None:
    """Unlock a temporary and remove it where it still is."""
    handle = _held.pop(path, None)
    _remove(path)
    if handle is not None:
        os.close(handle)


def discard_all() -> None:
    """Remove all temporaries of this process, for a process that is about to end."""
    for path in list(_held):
        discard(path)


def remove_stale_temporaries(folder: Path) -> None:
    """Remove the temporaries in ``folder`` that killed runs left, once in a process's life."""
    if folder in _swept:
        return
    _swept.add(folder)
    try:
        names = [entry.name for entry in os.scandir(folder) if _NAME.fullmatch(entry.name)]
    except OSError:
        return
    for name in names:
        _remove_if_free(folder / name)


def _claim(target: Path, flags: int) -> Path:
    remove_stale_temporaries(target.parent)
    head = target.name[:_LONGEST]
    for left in reversed(range(_ATTEMPTS)):
        unique = f"servosight-{os.getpid()}-{os.urandom(4).hex()}"
        if flags & os.O_DIRECTORY:
            path = target.with_name(f".{head}.{unique}")
            path.mkdir(mode=0o700)
        else:
            path = target.with_name(f".{head}.{unique}{_ending(target)}")
        try:
            handle = os.open(path, flags, 0o600)
        except FileNotFoundError:  # another run swept it before it was locked
            if not left or not target.parent.is_dir():
                raise  # /proc is a folder in which no file can be made
            continue
        _held[path] = handle
        if _lock(handle) and path.exists():
            return path
        discard(path)
    raise OSError(f"no temporary beside {target.name} could be locked")


def _ending(target: Path) -> str:
    return target.suffix if re.fullmatch(r"\.\w{1,10}", target.suffix) else ""


def _lock(handle: int) -> bool:
    """False where another process holds it; a file system without locks counts as free."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _remove_if_free(path: Path) -> None:
    """Remove a temporary that no process has locked; without locks, none is removed."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # A folder in the middle of being exchanged holds the only copy of what it replaces.
        if not (path / "old").exists():
            _remove(path)
    except OSError:
        return
    finally:
        os.close(handle)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        return
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return
