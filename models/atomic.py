"""Files and folders that are written whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from servosight.models.errors import InputError


def write_text(path: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with plain line ends, whole or not at all."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, data: bytes) -> None:
    """Write ``data`` whole or not at all; InputError where the place cannot be written."""
    target = Path(os.path.realpath(path))  # a link keeps pointing at what it points at
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(data)  # a pipe or a device has no old content to keep
            return
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.")
        temporary = Path(name)
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(data)
            temporary.chmod(_mode(target))
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
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
    target = Path(os.path.realpath(path))
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem[:100]}.", suffix=target.suffix
        )
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            temporary.chmod(_mode(target))
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(path, error) from None


def check_target(path: Path) -> None:
    """Refuse a place that cannot be written, before the work whose result shall go there."""
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise InputError(
            f"{path}: is a folder, expected the name of a file to write; add a name to it"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"{path}: the folder {path.parent} does not exist, expected an existing one; make it "
            f"or choose another"
        )
    if not os.access(target if target.exists() else target.parent, os.W_OK):
        raise InputError(
            f"{path}: may not be written, expected a place of your own; choose another or mend "
            f"its permissions"
        )


@contextmanager
def new_folder(folder: Path, replaceable: Collection[str]) -> Iterator[Path]:
    """A folder to fill that takes the place of ``folder`` when the block ends without an error.

    Missing parents are made. An existing folder is replaced only where it holds nothing but
    ``replaceable`` names; otherwise InputError, and nothing is touched.
    """
    target = Path(os.path.realpath(folder))
    try:
        others = sorted({entry.name for entry in target.iterdir()} - set(replaceable))
    except FileNotFoundError:
        others = []
    except OSError as error:
        raise unwritable(folder, error) from None
    if others:
        raise InputError(
            f"{folder}: the folder holds {others[0]!r}, which would be lost; expected a new or "
            f"empty folder, so choose another name or move the file away"
        )
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name[:100]}."))
    except OSError as error:
        raise unwritable(folder, error) from None
    try:
        fresh = stage / "new"
        fresh.mkdir()
        yield fresh
        if target.exists():
            target.rename(stage / "old")
        fresh.rename(target)
    finally:
        if not target.exists() and (stage / "old").exists():
            (stage / "old").rename(target)
        shutil.rmtree(stage, ignore_errors=True)


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
