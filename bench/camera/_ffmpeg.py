"""Any source that FFmpeg reads, through PyAV: RTSP, a file, a pipe.

MJPEG comes through untouched, other codings are decoded to grey. A file's presentation times are
the start of exposure, as everywhere in the project. A network stream's come from the camera's clock
with a latency that is not known, so that their meaning is that of an arrival.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

from servosight.bench.camera._protocol import (
    CameraLost,
    CapturedFrame,
    Given,
    Now,
    Stream,
    check_size,
)
from servosight.models.core import InputError

_LIVE = ("rtsp:", "rtsps:", "rtp:", "udp:", "tcp:", "srt:", "rtmp:")


class FfmpegCamera:
    """An open source of FFmpeg's."""

    def __init__(self, address: str, given: Given, now: Now) -> None:
        import av

        self.name = address
        self._given, self._now = given, now
        live = address.startswith(_LIVE)
        if not live and not Path(address).exists():
            raise InputError(f"{address}: no such file; expected a video, check the name")
        options = {"rtsp_transport": "tcp"} if address.startswith("rtsp") else {}
        try:
            self._container: Any = av.open(
                address, options=options, timeout=given.timeout_s, metadata_errors="replace"
            )
        except (av.FFmpegError, OSError, ValueError) as error:
            raise CameraLost(
                f"{address}: cannot be opened ({_words(error)}); expected a stream or a video that "
                f"FFmpeg reads, check the address and that the camera is on"
            ) from None
        if not self._container.streams.video:
            self.close()
            raise InputError(f"{address}: holds no video; expected one, check the address")
        self._video: Any = self._container.streams.video[0]
        context: Any = self._video.codec_context  # None for a coding that FFmpeg does not know
        if context is None:
            self.close()
            raise InputError(
                f"{address}: its video is of a coding that FFmpeg does not know; expected one that "
                f"it decodes, record it anew or convert it"
            )
        self._untouched = context.name == "mjpeg"
        rate = self._video.average_rate or self._video.guessed_rate
        size = int(context.width), int(context.height)
        check_size(address, size)
        self.stream = given.over(
            Stream(
                size=size,
                coding="mjpeg" if self._untouched else "gray",
                meaning="arrival" if live else "exposure_start",
                rate_hz=float(rate) if rate else None,
            )
        )

    def frames(self) -> Generator[CapturedFrame]:
        """The pictures; ends where the source does."""
        import av

        count = 0
        try:
            for packet in self._container.demux(self._video):
                arrival_s = self._now()
                for pts, data in self._pictures(packet):
                    stamp_s = arrival_s if pts is None else float(pts * self._video.time_base)
                    yield CapturedFrame(
                        number=count, stamp_s=stamp_s, arrival_s=arrival_s, data=data
                    )
                    count += 1
        except (av.FFmpegError, OSError) as error:
            raise CameraLost(
                f"{self.name}: no frame came within {self._given.timeout_s:g} s "
                f"({_words(error)}); check the camera and its link"
            ) from None

    def close(self) -> None:
        """Leave the source."""
        self._container.close()

    def _pictures(self, packet: Any) -> Iterator[tuple[int | None, bytes]]:
        if self._untouched:
            if packet.size:
                yield packet.pts, bytes(packet)
            return
        for picture in packet.decode():
            yield picture.pts, picture.to_ndarray(format="gray").tobytes()


def _words(error: Exception) -> str:
    text = getattr(error, "strerror", None) or str(error)
    return str(text).strip().rstrip(".").lower()


def open_ffmpeg(address: str, given: Given, now: Now) -> FfmpegCamera:
    """Open whatever FFmpeg opens."""
    return FfmpegCamera(address, given, now)
