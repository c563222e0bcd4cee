"""A Matroska file of one video track whose time stamps are microseconds.

FFmpeg's own Matroska writer rounds every time stamp to a millisecond, which at 300 deg/s is 0.3 deg
in an angle. The format itself allows any unit (RFC 9559, ``TimestampScale``), and the little of it
that one track without reordering needs is written here. The same input gives the same bytes.
"""

from __future__ import annotations

import struct
from types import TracebackType
from typing import Protocol

TICK_S = 1e-6
"""The unit of the time stamps."""

_CLUSTER_TICKS = 30_000  # time stamps within a cluster have 16 bits with sign
_UNKNOWN_SIZE = b"\x01" + 7 * b"\xff"

# Element identifiers, RFC 9559, section 5.
_EBML, _EBML_VERSION, _EBML_READ_VERSION = 0x1A45DFA3, 0x4286, 0x42F7
_EBML_MAX_ID, _EBML_MAX_SIZE = 0x42F2, 0x42F3
_DOC_TYPE, _DOC_VERSION, _DOC_READ_VERSION = 0x4282, 0x4287, 0x4285
_SEGMENT, _INFO, _SCALE, _DURATION, _MUXER, _WRITER = (
    0x18538067, 0x1549A966, 0x2AD7B1, 0x4489, 0x4D80, 0x5741,
)  # fmt: skip
_TRACKS, _ENTRY, _NUMBER, _UID, _TYPE, _LACING = 0x1654AE6B, 0xAE, 0xD7, 0x73C5, 0x83, 0x9C
_CODEC, _PRIVATE, _PERIOD, _VIDEO, _WIDTH, _HEIGHT = 0x86, 0x63A2, 0x23E383, 0xE0, 0xB0, 0xBA
_CLUSTER, _TIMESTAMP, _BLOCK = 0x1F43B675, 0xE7, 0xA3
_CUES, _CUE_POINT, _CUE_TIME, _CUE_PLACES = 0x1C53BB6B, 0xBB, 0xB3, 0xB7
_CUE_TRACK, _CUE_CLUSTER = 0xF7, 0xF1


class Seekable(Protocol):
    """What the writer needs of a binary file."""

    def write(self, data: bytes, /) -> int:
        """Write all of it."""

    def tell(self) -> int:
        """The position [bytes]."""

    def seek(self, place: int, /) -> int:
        """Go to a position [bytes]."""


class MatroskaWriter:
    """Writes one video track to a seekable binary file; close by leaving its ``with`` block.

    ``packets`` counts the pictures that have been handed to the file. After an OSError of the file
    ``cut`` says up to where it is whole.
    """

    def __init__(
        self,
        file: Seekable,
        size: tuple[int, int],
        codec: str,
        codec_private: bytes,
        period_s: float,
    ) -> None:
        """``size``: width and height [px]; ``codec``: Matroska's identifier, such as V_FFV1."""
        self._file = file
        self._period_s = period_s
        self._cluster: list[tuple[int, bool, bytes]] = []
        self._cues: list[bytes] = []
        self._last = 0
        self.packets = 0
        file.write(
            _element(
                _EBML,
                _uint(_EBML_VERSION, 1)
                + _uint(_EBML_READ_VERSION, 1)
                + _uint(_EBML_MAX_ID, 4)
                + _uint(_EBML_MAX_SIZE, 8)
                + _element(_DOC_TYPE, b"matroska")
                + _uint(_DOC_VERSION, 4)
                + _uint(_DOC_READ_VERSION, 2),
            )
        )
        file.write(_identifier(_SEGMENT))
        self._size_at = file.tell()
        file.write(_UNKNOWN_SIZE)
        self._segment = file.tell()
        info = _uint(_SCALE, round(TICK_S * 1e9)) + b"".join(
            _element(key, b"servosight") for key in (_MUXER, _WRITER)
        )
        file.write(_element(_INFO, info + _float(_DURATION, 0.0)))
        self._duration_at = file.tell() - 8
        video = _uint(_WIDTH, size[0]) + _uint(_HEIGHT, size[1])
        private = _element(_PRIVATE, codec_private) if codec_private else b""
        file.write(
            _element(
                _TRACKS,
                _element(
                    _ENTRY,
                    _uint(_NUMBER, 1)
                    + _uint(_UID, 1)
                    + _uint(_TYPE, 1)
                    + _uint(_LACING, 0)
                    + _element(_CODEC, codec.encode())
                    + private
                    + _uint(_PERIOD, round(period_s * 1e9))
                    + _element(_VIDEO, video),
                ),
            )
        )
        self._whole = file.tell()

    def write(self, ticks: int, packet: bytes, key: bool = True) -> None:
        """Append a picture shown at ``ticks`` >= 0, in rising order; ``key``: it is a key frame."""
        if self._cluster and ticks - self._cluster[0][0] > _CLUSTER_TICKS:
            self._flush()
        self._cluster.append((ticks, key, packet))
        self._last = ticks

    def cut(self) -> int:
        """Leave out what ``packets`` does not count; the place where the file is to end [bytes]."""
        self._cluster = []
        self._file.seek(self._whole)
        return self._whole

    def close(self) -> None:
        """Write the last cluster, the index, and the sizes that the header left open."""
        self._flush()
        self._file.write(_element(_CUES, b"".join(self._cues)))
        end = self._file.tell()
        self._file.seek(self._size_at)
        self._file.write(_size(end - self._segment))
        self._file.seek(self._duration_at)
        self._file.write(struct.pack(">d", self._last + self._period_s / TICK_S))
        self._file.seek(end)

    def __enter__(self) -> MatroskaWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()

    def _flush(self) -> None:
        if not self._cluster:
            return
        start = self._cluster[0][0]
        place = _uint(_CUE_TRACK, 1) + _uint(_CUE_CLUSTER, self._file.tell() - self._segment)
        for ticks, key, _ in self._cluster:
            if key:  # where a reader may begin
                point = _uint(_CUE_TIME, ticks) + _element(_CUE_PLACES, place)
                self._cues.append(_element(_CUE_POINT, point))
                break
        # Track 1, time within the cluster, a key frame or not, without lacing.
        blocks = b"".join(
            _element(
                _BLOCK, b"\x81" + struct.pack(">hB", ticks - start, 0x80 if key else 0) + packet
            )
            for ticks, key, packet in self._cluster
        )
        self._file.write(_element(_CLUSTER, _uint(_TIMESTAMP, start) + blocks))
        self._whole = self._file.tell()
        self.packets += len(self._cluster)
        self._cluster = []


def _identifier(key: int) -> bytes:
    return key.to_bytes((key.bit_length() + 7) // 8, "big")


def _size(count: int) -> bytes:
    """A length in eight bytes, as RFC 8794 codes it: always room to be written later."""
    return (count | 1 << 56).to_bytes(8, "big")


def _element(key: int, content: bytes) -> bytes:
    return _identifier(key) + _size(len(content)) + content


def _uint(key: int, value: int) -> bytes:
    return _element(key, value.to_bytes(max(1, (value.bit_length() + 7) // 8), "big"))


def _float(key: int, value: float) -> bytes:
    return _element(key, struct.pack(">d", value))
