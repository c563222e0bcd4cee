"""Grey pictures to packets of FFV1, without loss."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from servosight.models.core import Image

TICK = Fraction(1, 1_000_000)
"""The unit of the time stamps of what is encoded [s]."""


class Ffv1Encoder:
    """FFV1, level 3, every frame a key frame (RFC 9043)."""

    matroska_id = "V_FFV1"

    def __init__(self, width: int, height: int) -> None:
        self._context = codec_context("ffv1", width, height, "gray")
        self._context.options = {"level": "3", "g": "1", "slices": "4", "slicecrc": "1"}
        self._context.open()
        self.private = bytes(self._context.extradata or b"")

    def encode(self, image: Image) -> bytes:
        import av

        frame = av.VideoFrame.from_ndarray(image, format="gray")
        (packet,) = self._context.encode(frame)
        return bytes(packet)


def codec_context(name: str, width: int, height: int, pixels: str) -> Any:
    """A single-threaded encoder ``name`` of FFmpeg, in microseconds, to be opened."""
    import av

    context: Any = av.VideoCodecContext.create(name, "w")
    context.width, context.height, context.pix_fmt = width, height, pixels
    context.time_base = TICK
    context.thread_count = 1
    return context
