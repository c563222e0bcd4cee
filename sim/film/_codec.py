"""Pictures to packets: without loss, JPEG for each picture, or H.264 across pictures."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Protocol

import cv2
import numpy as np

from servosight.models.core import Image, within
from servosight.models.io import TICK, Ffv1Encoder, codec_context

NAMES = ("magicyuv", "ffv1", "mjpeg", "h264")


@dataclass(frozen=True)
class Codec:
    """``name``: one of :data:`NAMES`. ``quality``: JPEG's, 1 to 100. ``crf``: H.264's, 0 to 51.

    MagicYUV and FFV1 are exact, and grey as JPEG is; H.264 is the 4:2:0 of limited range that
    cameras record.
    """

    name: str = "magicyuv"
    quality: Annotated[int, within(1, 100, "")] = 80
    crf: Annotated[int, within(0, 51, "")] = 23


@dataclass(frozen=True)
class Packet:
    """A compressed picture, when it is shown [ticks], and whether it is a key frame."""

    ticks: int
    data: bytes
    key: bool = True


class FrameEncoder(Protocol):
    """Compresses single pictures; the results of several encoders make one stream."""

    matroska_id: str
    private: bytes

    def encode(self, image: Image) -> bytes:
        """The bytes of one picture (height, width) in the stream."""


class MagicYuvEncoder:
    """MagicYUV, every frame a key frame: exact, and eight times as fast to read as FFV1."""

    matroska_id = "V_MS/VFW/FOURCC"

    def __init__(self, width: int, height: int) -> None:
        self._context = codec_context("magicyuv", width, height, "gray")
        self._context.options = {"pred": "median"}
        self._context.open()
        self.private = bitmap_header(width, height, b"M8G0")

    def encode(self, image: Image) -> bytes:
        import av

        (packet,) = self._context.encode(av.VideoFrame.from_ndarray(image, format="gray"))
        return bytes(packet)


def bitmap_header(width: int, height: int, code: bytes) -> bytes:
    """The BITMAPINFOHEADER by which Matroska names a codec of Windows: RFC 9559, section 6.

    Grey levels of 8 bits, in the format of four letters ``code``.
    """
    size = 40
    return struct.pack("<IiiHH4sIiiII", size, width, height, 1, 8, code, width * height, 0, 0, 0, 0)


class JpegEncoder:
    """One grey JPEG for each picture, with the usual tables at ``quality``."""

    matroska_id = "V_MJPEG"
    private = b""

    def __init__(self, quality: int) -> None:
        self._options = [cv2.IMWRITE_JPEG_QUALITY, quality]

    def encode(self, image: Image) -> bytes:
        done, data = cv2.imencode(".jpg", image, self._options)
        if not done:
            raise RuntimeError("OpenCV could not write a JPEG")
        return data.tobytes()


class RawFrame:
    """The picture uncompressed: H.264 needs the pictures before it, see :class:`PacketStream`."""

    matroska_id = "V_MPEG4/ISO/AVC"
    private = b""

    def encode(self, image: Image) -> bytes:
        return image.tobytes()


def frame_encoder(codec: Codec, width: int, height: int) -> FrameEncoder:
    """The encoder of single pictures for ``codec``."""
    if codec.name == "magicyuv":
        return MagicYuvEncoder(width, height)
    if codec.name == "ffv1":
        return Ffv1Encoder(width, height)
    if codec.name == "mjpeg":
        return JpegEncoder(codec.quality)
    return RawFrame()


class PacketStream:
    """Turns encoded pictures, in order, into packets of the file; H.264 is compressed here."""

    def __init__(self, codec: Codec, width: int, height: int, rate_hz: float) -> None:
        encoder = frame_encoder(codec, width, height)
        self.matroska_id, self.private = encoder.matroska_id, encoder.private
        self._shape = (height, width)
        self._h264: Any = None
        if codec.name == "h264":
            self._h264 = _h264(codec.crf, width, height, rate_hz)
            self.private = avc_configuration(bytes(self._h264.extradata))

    def packets(self, ticks: int, data: bytes) -> Iterator[Packet]:
        """The packets that can be written after the picture shown at ``ticks``."""
        if self._h264 is None:
            yield Packet(ticks, data)
            return
        import av

        image = np.frombuffer(data, dtype=np.uint8).reshape(self._shape)
        frame = av.VideoFrame.from_ndarray(image, format="gray").reformat(format="yuv420p")
        frame.pts, frame.time_base = ticks, TICK
        yield from map(_packet, self._h264.encode(frame))

    def rest(self) -> Iterator[Packet]:
        """The packets that the codec still buffers."""
        if self._h264 is not None:
            yield from map(_packet, self._h264.encode(None))


def _h264(crf: int, width: int, height: int, rate_hz: float) -> Any:
    """x264 set up like the chip of a camera: no reordered pictures, one key frame a second."""
    from av.codec.context import Flags

    context = codec_context("libx264", width, height, "yuv420p")
    context.framerate = Fraction(rate_hz).limit_denominator(1000)
    context.flags |= Flags.global_header
    options = {"crf": str(crf), "preset": "medium", "bf": "0", "g": str(max(round(rate_hz), 1))}
    context.options = options
    context.open()
    return context


def _packet(packet: Any) -> Packet:
    return Packet(int(packet.pts), length_prefixed(bytes(packet)), bool(packet.is_keyframe))


def units(stream: bytes) -> list[bytes]:
    """The units of an H.264 byte stream, separated by start codes (ITU-T H.264, annex B)."""
    return [unit.rstrip(b"\0") for unit in stream.split(b"\0\0\1")[1:]]


def length_prefixed(stream: bytes) -> bytes:
    """The same units, each after its length, as Matroska and MP4 require."""
    return b"".join(len(unit).to_bytes(4, "big") + unit for unit in units(stream))


def avc_configuration(stream: bytes) -> bytes:
    """Parameter sets as an AVCDecoderConfigurationRecord (ISO/IEC 14496-15, 5.3.3.1)."""
    found = units(stream)
    sequence = [unit for unit in found if unit[0] & 31 == 7]
    picture = [unit for unit in found if unit[0] & 31 == 8]
    record = b"\1" + sequence[0][1:4] + b"\xff"  # lengths of four bytes
    for mark, group in ((0xE0, sequence), (0, picture)):
        record += bytes([mark | len(group)])
        record += b"".join(len(unit).to_bytes(2, "big") + unit for unit in group)
    return record
