"""What a JPEG's header says, read without decoding it."""

from __future__ import annotations

import struct

_NO_LENGTH = {0x01, *range(0xD0, 0xDA)}  # markers that stand alone
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}  # start of frame, ITU-T T.81 table B.1


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Width and height [px] of a JPEG; None where the bytes are none.

    >>> jpeg_size(b"no picture") is None
    True
    """
    if data[:2] != b"\xff\xd8":
        return None
    at = 2
    while at + 9 <= len(data):
        if data[at] != 0xFF:
            return None
        marker = data[at + 1]
        if marker in _NO_LENGTH or marker == 0xFF:
            at += 1 if marker == 0xFF else 2
        elif marker in _FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return int(width), int(height)
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
