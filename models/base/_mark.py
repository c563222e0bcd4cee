"""The mark by which the program recognises what it wrote, so that it replaces nothing else.

TOML and HTML carry it at their head, PNG and video in their metadata, exported models in a comment
at their head or, where they are archives, at their end; a JSON result is known by how
it begins. CSV carries no mark, for other programs read it: an existing table counts as the user's.
So does a drafted plugin, which is there to be edited.
"""

from __future__ import annotations

import struct
import zlib
from enum import Enum
from pathlib import Path

MARK = "Written by servosight"
_JSON = b'{\n  "schema": '
_PNG = b"\x89PNG\r\n\x1a\n"
_MATROSKA = b"\x1a\x45\xdf\xa3"
_PAGE_HEAD = 1 << 10
_METADATA = 1 << 16


class Kind(Enum):
    """What the program writes: files that carry its mark, and those that count as the user's."""

    MODEL = "model card"
    CAMERA = "camera"
    JSON = "JSON"
    HTML = "HTML"
    PNG = "PNG"
    VIDEO = "video"
    TABLE = "table"
    PLUGIN = "plugin"
    EXPORT = "export"


def kind_of(path: Path) -> Kind | None:
    """What an existing file is, where it shows that servosight wrote it; else None."""
    try:
        with path.open("rb") as file:
            head = file.read(_METADATA)
            file.seek(max(file.seek(0, 2) - _METADATA, 0))
            tail = file.read(_METADATA)
    except OSError:
        return None
    mark = MARK.encode()
    for kind in (Kind.MODEL, Kind.CAMERA):
        if head.startswith(_head(kind).encode()):
            return kind
    exported = f"{MARK}: {Kind.EXPORT.value}".encode()
    if exported in head[:_PAGE_HEAD] or exported in tail[-_PAGE_HEAD:]:
        return Kind.EXPORT
    if head.startswith(_JSON):
        return Kind.JSON
    if head.startswith(b"<!doctype html>") and mark in head[:_PAGE_HEAD]:
        return Kind.HTML
    if head.startswith(_PNG) and mark in head[:_PAGE_HEAD]:
        return Kind.PNG
    if (head[4:8] == b"ftyp" or head.startswith(_MATROSKA)) and (mark in head or mark in tail):
        return Kind.VIDEO
    return None


def marked_toml(kind: Kind, text: str) -> str:
    """A TOML file's text behind the mark."""
    return _head(kind) + text


def _head(kind: Kind) -> str:
    return f"# {MARK}: {kind.value}\n"


def marked_png(data: bytes) -> bytes:
    """A PNG file with the mark as its first text chunk (PNG specification 1.2, section 4.2.3)."""
    text = b"tEXtSoftware\0" + MARK.encode()
    chunk = struct.pack(">I", len(text) - 4) + text + struct.pack(">I", zlib.crc32(text))
    header = len(_PNG) + 4 + 4 + 13 + 4  # the signature and the chunk IHDR
    return data[:header] + chunk + data[header:]
