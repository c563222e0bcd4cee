"""The text of a log, in whichever encoding a program on Windows or elsewhere wrote it."""

from __future__ import annotations

from pathlib import Path

from servosight.models.core import InputError, read_bytes

UTF_16 = (b"\xff\xfe", b"\xfe\xff")
"""Byte-order marks of UTF-16."""
_ENCODINGS = ("utf-8-sig", "cp1252")
"""UTF-8 is what almost no text of another encoding can be; of those, Windows writes its own."""


def log_text(path: Path, expected: str, largest: int) -> str:
    """The text of a regular file in UTF-8, UTF-16 with its mark, or Windows-1252.

    InputError where it is none; ``expected`` names the kind of file.
    """
    data = read_bytes(path, expected, largest)
    encodings = ("utf-16",) if data.startswith(UTF_16) else _ENCODINGS
    for encoding in encodings:
        try:
            return data.decode(encoding)
        except UnicodeDecodeError as error:
            last = error
    line = data.count(b"\n", 0, last.start) + 1
    raise InputError(
        f"{path}, row {line}: byte 0x{data[last.start]:02x} is no text, expected {expected}; save "
        f"the file as plain text in UTF-8"
    )
