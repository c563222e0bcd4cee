"""MCAP files without their end, as a recorder leaves that was interrupted: mcap.dev/spec.

A reader finds the messages by the footer, the last bytes of a file. Records stand one behind the
other, so that those before the cut are whole: a copy of them with a footer of its own is a file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

MAGIC = b"\x89MCAP0\r\n"
_RECORD = struct.Struct("<BQ")
_CHUNK, _DATA_END = 0x06, 0x0F
_END = b"".join(
    (
        _RECORD.pack(_DATA_END, 4) + bytes(4),
        _RECORD.pack(0x02, 20) + bytes(20),  # a footer that names no summary
        MAGIC,
    )
)
_CHUNK_HEAD = 28
"""Bytes of a chunk in front of the name of its compression: two times, a size and a checksum."""


def with_end(path: Path, place: Path) -> bool:
    """True where the file at ``path`` has no end: the whole records before are then at ``place``.

    Of a chunk that is cut off its messages are kept, unless they are compressed.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(size - len(MAGIC), 0))
        if stream.read() == MAGIC:
            return False
        stream.seek(len(MAGIC))
        with place.open("wb") as copy:
            copy.write(MAGIC)
            copy.writelines(_whole_records(stream, size))
            copy.write(_END)
    return True


def _whole_records(stream: BinaryIO, end: int) -> Iterator[bytes]:
    """The records up to the end of the data, or to the first that is not whole."""
    while len(head := stream.read(_RECORD.size)) == _RECORD.size:
        kind, size = _RECORD.unpack(head)
        if kind in (0, _DATA_END):
            return
        content = stream.read(min(size, end - stream.tell()))
        if len(content) == size:
            yield head + content
        elif kind == _CHUNK:
            inner = _plain_records(content)
            yield from _whole_records(BytesIO(inner), len(inner))


def _plain_records(chunk: bytes) -> bytes:
    """What is there of the records in a chunk; nothing where they are compressed."""
    compression = chunk[_CHUNK_HEAD : _CHUNK_HEAD + 4]
    return chunk[_CHUNK_HEAD + 12 :] if compression == bytes(4) else b""
