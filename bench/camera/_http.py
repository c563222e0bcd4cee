"""MJPEG over HTTP: what mjpg-streamer, ustreamer, ESP32-CAM and many IP cameras serve.

The answer is ``multipart/x-mixed-replace``: one part for each picture, a JPEG behind a few header
lines (RFC 2046, section 5.1). ``X-Timestamp``, in seconds, is the picture's time on the camera's
clock; mjpg-streamer and ESP32-CAM send it. Without it, and from FFmpeg, which passes over these
lines, only the time of receipt is known. ``X-Sequence`` numbers the pictures, where a camera does.
"""

from __future__ import annotations

import http.client
import math
from collections.abc import Generator
from contextlib import closing
from typing import BinaryIO
from urllib.parse import urlsplit

from servosight.bench.camera._jpeg import jpeg_size
from servosight.bench.camera._protocol import (
    CameraLost,
    CapturedFrame,
    Given,
    Now,
    Stream,
    check_size,
)
from servosight.bench.timing import Meaning
from servosight.models.core import InputError

_LARGEST_PART = 64 * 2**20
_LONGEST_LINE = 8192
_MOST_LINES = 64
_END = b"\xff\xd9"  # end of image


class HttpCamera:
    """An open stream of MJPEG over HTTP."""

    def __init__(self, address: str, given: Given, now: Now) -> None:
        self.name = address
        self._now = now
        self._timeout_s = given.timeout_s
        self._connection = _connection(address, given.timeout_s)
        self._count = 0
        self._file: BinaryIO | None = None
        # One picture now, and the stream anew when it is wanted: a server or the network would
        # otherwise keep old pictures until then.
        with closing(self.frames()) as frames:
            first = next(frames)
        size = jpeg_size(first.data)
        if size is None:
            raise InputError(
                f"{address}: sends parts that are no JPEG; expected MJPEG over HTTP, give the "
                f"address of the stream itself, such as http://HOST:8080/?action=stream"
            )
        check_size(address, size)
        meaning: Meaning = "frame_end" if first.stamp_s != first.arrival_s else "arrival"
        self.stream = given.over(Stream(size=size, coding="mjpeg", meaning=meaning))

    def frames(self) -> Generator[CapturedFrame]:
        """The pictures from now on; closing the generator leaves the stream."""
        self._count = 0
        try:
            self._ask(self.name)
            while True:
                yield self._next()
        finally:
            self.close()

    def close(self) -> None:
        """Leave the stream."""
        if self._file is not None:  # the answer has the socket
            self._file.close()
            self._file = None
        self._connection.close()

    def _ask(self, address: str) -> None:
        parts = urlsplit(address)
        path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        try:
            self._connection.request("GET", path, headers={"User-Agent": "servosight"})
            answer = self._connection.getresponse()
        except (OSError, http.client.HTTPException) as error:
            raise CameraLost(
                f"{address}: does not answer ({_words(error)}); expected an MJPEG stream there, "
                f"check that the camera is on and the address right"
            ) from None
        kind = answer.getheader("Content-Type", "")
        self._file = answer
        if answer.status != 200 or not kind.startswith("multipart/"):
            raise InputError(
                f"{address}: answers with status {answer.status} and {kind or 'no type'}; expected "
                f"multipart/x-mixed-replace, give the address of the stream itself"
            )

    def _next(self) -> CapturedFrame:
        try:
            headers = self._headers()
            data = self._body(headers)
        except (OSError, http.client.HTTPException, ValueError) as error:
            raise CameraLost(
                f"{self.name}: no whole picture came within {self._timeout_s:g} s "
                f"({_words(error)}); check the camera and its link"
            ) from None
        arrival_s = self._now()
        number, stamp_s = self._count, _number(headers.get("x-timestamp"))
        sequence = _number(headers.get("x-sequence"))
        if sequence is not None:
            number = int(sequence)
        self._count = number + 1
        return CapturedFrame(
            number=number,
            stamp_s=arrival_s if stamp_s is None else stamp_s,
            arrival_s=arrival_s,
            data=data,
        )

    def _headers(self) -> dict[str, str]:
        """The header lines of the next part, behind its boundary."""
        found: dict[str, str] = {}
        begun = False
        for _ in range(_MOST_LINES):
            line = self._stream().readline(_LONGEST_LINE)
            if not line:
                raise ValueError("the stream ended")
            text = line.decode("latin-1").strip()
            if text.startswith("--"):
                begun = True
            elif not text and begun:
                return found
            elif begun and ":" in text:
                key, _, value = text.partition(":")
                found[key.strip().lower()] = value.strip()
        raise ValueError("a part without a picture")

    def _stream(self) -> BinaryIO:
        if self._file is None:
            raise ValueError("the stream is closed")
        return self._file

    def _body(self, headers: dict[str, str]) -> bytes:
        length = _number(headers.get("content-length"))
        if length is None:
            return self._until_end()
        if not 0 < length <= _LARGEST_PART:
            raise ValueError(f"a part of {length:g} bytes")
        data = self._stream().read(int(length))
        if len(data) < int(length):
            raise ValueError("the stream ended within a picture")
        return data

    def _until_end(self) -> bytes:
        """A part whose length is not given: up to the end of its JPEG."""
        data = bytearray()
        while not data.rstrip(b"\r\n").endswith(_END):
            line = self._stream().readline(2**20)
            if not line or len(data) > _LARGEST_PART:
                raise ValueError("the stream ended within a picture")
            data += line
        return bytes(data.rstrip(b"\r\n"))


def _connection(address: str, timeout_s: float) -> http.client.HTTPConnection:
    parts = urlsplit(address)
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if not host:
        raise InputError(
            f"{address}: names no host; expected an address such as http://HOST:8080/?action=stream"
        )
    kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
    return kind(host, port, timeout=timeout_s)


def _number(text: str | None) -> float | None:
    try:
        value = float(text) if text is not None else math.nan
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _words(error: Exception) -> str:
    return str(error).strip().rstrip(".").lower() or type(error).__name__.lower()


def open_http(address: str, given: Given, now: Now) -> HttpCamera:
    """Open ``http://HOST:PORT/PATH``."""
    return HttpCamera(address, given, now)
