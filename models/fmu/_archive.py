"""An FMU's archive, checked before anything of it is written to disk.

An archive from elsewhere may name places outside its folder, link there, or be small and unpack to
more than the disk holds. What no honest FMU has is refused, in one sentence.
"""

from __future__ import annotations

import os
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from servosight.models.core import InputError, check_path
from servosight.models.fmu._folder import own_folder

DESCRIPTION = "modelDescription.xml"
_CHUNK = 1 << 20


@dataclass(frozen=True, kw_only=True)
class ArchiveLimits:
    """The most that an FMU may hold; a ratio counts for entries of more than ``small`` bytes."""

    file_bytes: int = 1 << 29
    entries: int = 4096
    entry_bytes: int = 1 << 29
    total_bytes: int = 1 << 30
    description_bytes: int = 1 << 24
    ratio: float = 200.0
    small: int = 1 << 20
    name_length: int = 1024


LIMITS = ArchiveLimits()


@contextmanager
def unpacked(path: Path, limits: ArchiveLimits = LIMITS) -> Iterator[Path]:
    """A temporary folder with the archive's files; InputError where it is not to be unpacked."""
    check_path(path)
    with own_folder() as folder:
        try:
            if path.stat().st_size > limits.file_bytes:
                raise _bad(path, f"has more than {limits.file_bytes:,} bytes", "a smaller one")
            with zipfile.ZipFile(path) as archive:
                _check(path, archive, limits)
                _extract(path, archive, folder)
        except (zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, EOFError) as error:
            raise _bad(path, f"is no whole zip archive ({_line(error)})") from None
        except (NotImplementedError, ValueError, UnicodeError) as error:
            raise _bad(path, f"cannot be unpacked ({_line(error)})") from None
        except (IsADirectoryError, FileNotFoundError, PermissionError) as error:
            raise _bad(path, f"cannot be read ({error.strerror})") from None
        yield folder


def _check(path: Path, archive: zipfile.ZipFile, limits: ArchiveLimits) -> None:
    entries = archive.infolist()
    if len(entries) > limits.entries:
        raise _bad(path, f"has {len(entries)} entries", f"at most {limits.entries}")
    total = 0
    seen: set[str] = set()
    for entry in entries:
        _check_name(path, entry, limits)
        _check_size(path, entry, limits)
        if entry.filename.casefold() in seen:
            raise _bad(path, f"has two entries {_shown(entry)}")
        seen.add(entry.filename.casefold())
        total += entry.file_size
    if total > limits.total_bytes:
        raise _bad(path, f"unpacks to {total:,} bytes", f"at most {limits.total_bytes:,}")
    if DESCRIPTION not in archive.namelist():
        raise _bad(path, f"has no {DESCRIPTION}")
    if archive.getinfo(DESCRIPTION).file_size > limits.description_bytes:
        raise _bad(path, f"has a {DESCRIPTION} of more than {limits.description_bytes:,} bytes")


def _check_name(path: Path, entry: zipfile.ZipInfo, limits: ArchiveLimits) -> None:
    name = entry.filename
    parts = PurePosixPath(name).parts
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if "\\" in name:
        raise _bad(path, f"has the entry {_shown(entry)} with a backslash", "/ between folders")
    if entry.orig_filename != name or not name.isprintable() or len(name) > limits.name_length:
        raise _bad(path, f"has an entry with an unusable name, {_shown(entry)}")
    if name.startswith("/") or ".." in parts or (parts and ":" in parts[0]) or not parts:
        raise _bad(path, f"has the entry {_shown(entry)}, which leads out of its folder")
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        what = "a symbolic link" if kind == stat.S_IFLNK else "no plain file"
        raise _bad(path, f"has the entry {_shown(entry)}, which is {what}")


def _check_size(path: Path, entry: zipfile.ZipInfo, limits: ArchiveLimits) -> None:
    if entry.flag_bits & 1:
        raise _bad(path, f"has the encrypted entry {_shown(entry)}")
    if entry.file_size > limits.entry_bytes:
        raise _bad(path, f"has the entry {_shown(entry)} of {entry.file_size:,} bytes")
    ratio = entry.file_size / max(entry.compress_size, 1)
    if entry.file_size > limits.small and ratio > limits.ratio:
        raise _bad(path, f"has the entry {_shown(entry)}, which unpacks to {ratio:.0f} times")


def _extract(path: Path, archive: zipfile.ZipFile, folder: Path) -> None:
    """Write the files one by one; a folder and a file of one name are refused by the system."""
    for entry in archive.infolist():
        place = folder / entry.filename
        try:
            if entry.is_dir():
                place.mkdir(parents=True, exist_ok=True)
                continue
            place.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(entry) as source, place.open("xb") as target:
                while chunk := source.read(_CHUNK):
                    target.write(chunk)
        except (FileExistsError, NotADirectoryError, OSError) as error:
            said = os.strerror(error.errno) if error.errno else str(error)
            raise _bad(path, f"has the entry {_shown(entry)}, which cannot be written ({said})") \
                from None  # fmt: skip


def _bad(path: Path, what: str, expected: str = "") -> InputError:
    wanted = expected or "an FMU as FMI 2.0 or 3.0 has it"
    return InputError(f"{path}: {what}, expected {wanted}; export it again with the tool it is of")


def _shown(entry: zipfile.ZipInfo) -> str:
    return ascii(entry.filename[:60])


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
