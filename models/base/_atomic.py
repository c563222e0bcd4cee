"""Files and folders that are written completely or not at all."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from servosight.models.base._errors import InputError
from servosight.models.base._files import check_path
from servosight.models.base._temporary import discard, temporary_file, temporary_folder
from servosight.models.base._wording import either


def write_text(path: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with plain line ends, completely or not at all."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, data: bytes) -> None:
    """Write ``data`` completely or not at all; InputError where the place cannot be written."""
    check_path(path)
    target = Path(os.path.realpath(path))  # a link keeps pointing at what it points at
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(data)  # a pipe or a device has no old content to keep
            return
        with new_file(path) as temporary:
            temporary.write_bytes(data)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise unwritable(path, error) from None


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """A place to write a file piece by piece, which becomes ``path`` when the block ends.

    After an error, or an interruption, nothing is left and ``path`` is as it was. The place has the
    ending of ``path``.
    """
    check_path(path)
    target = Path(os.path.realpath(path))
    try:
        temporary = temporary_file(target)
        try:
            yield temporary
            temporary.chmod(_mode(target))
            os.replace(temporary, target)
        finally:
            discard(temporary)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise unwritable(path, error) from None


@contextmanager
def new_folder(
    folder: Path,
    replaceable: Collection[str],
    *,
    sign: str | None = None,
    force: bool = False,
) -> Iterator[Path]:
    """A folder to fill that takes the place of ``folder`` when the block ends without an error.

    Missing parents are made. What :func:`check_folder` refuses is refused, and nothing is touched.
    """
    check_folder(folder, replaceable, sign=sign, force=force)
    target = Path(os.path.realpath(folder))
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        stage = temporary_folder(target)
    except OSError as error:
        raise unwritable(folder, error) from None
    try:
        fresh = stage / "new"
        fresh.mkdir()
        yield fresh
        _exchange(fresh, target, stage / "old")
    except OSError as error:
        raise unwritable(folder, error) from None
    finally:
        discard(stage)


def make_folder(folder: Path) -> None:
    """Make a folder for results, where there is none yet; InputError where it cannot be made."""
    check_path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from None


def check_folder(
    folder: Path,
    replaceable: Collection[str],
    *,
    sign: str | None = None,
    force: bool = False,
) -> None:
    """Refuse a folder whose replacement would lose what the program did not make.

    A folder that is missing or empty is accepted; so is one that holds nothing but ``replaceable``
    names, if the file ``sign``, which shows who made it, is among them or ``force`` is given.
    """
    check_path(folder)
    target = Path(os.path.realpath(folder))
    try:
        names = {entry.name for entry in target.iterdir()}
    except FileNotFoundError:
        return
    except OSError as error:
        raise unwritable(folder, error) from None
    others = sorted(names - set(replaceable))
    if others:
        raise InputError(
            f"{folder}: the folder holds {others[0]!r}, which would be lost; expected a new or "
            f"empty folder, so choose another name or move the file away"
        )
    if names and not force and sign not in names:
        lost = "would be replaced" if sign is None else f"came from elsewhere (there is no {sign})"
        raise InputError(
            f"{folder}: the folder holds {min(names)!r}, which {lost}; expected a new or empty "
            f"folder, so choose another name or replace it with "
            f"{either('force=True', '--force')}"
        )


def _exchange(fresh: Path, target: Path, old: Path) -> None:
    """Put ``fresh`` in the place of ``target``, in one step where the system can."""
    if not target.exists():
        fresh.rename(target)
        return
    import ctypes

    swap = getattr(ctypes.CDLL(None), "renameat2", None)
    here, both = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    if swap is not None and swap(here, os.fsencode(fresh), here, os.fsencode(target), both) == 0:
        return
    target.rename(old)
    try:
        fresh.rename(target)
    except BaseException:
        old.rename(target)
        raise


def unwritable(path: Path, error: OSError) -> InputError:
    """The sentence for a place that cannot be written."""
    return InputError(
        f"{path}: cannot be written ({error.strerror or error}); expected a place in an existing "
        f"folder that you may write to, so make the folder or choose another"
    )


def _mode(target: Path) -> int:
    """The permissions of the file that is replaced, or those that a new file gets."""
    if target.exists():
        return target.stat().st_mode & 0o777
    mask = os.umask(0o077)
    os.umask(mask)
    return 0o666 & ~mask
