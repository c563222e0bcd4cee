"""A video file's container: opened or rejected in one sentence, and the data of its header."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import InputError

if TYPE_CHECKING:
    from av.container import InputContainer

MIN_FRAMES = 50
_TRANSPORT = (188, 192, 204)  # bytes of a packet
_PROGRESSIVE = 1  # FFmpeg's order of fields: 0 is unknown, 2 to 5 are interlaced


@contextmanager
def opened(video: Path) -> Iterator[InputContainer]:
    """The file's container; every error of FFmpeg becomes one sentence."""
    import av

    if not video.is_file():
        raise InputError(f"{video}: no such file; expected a video, give the path of one.")
    try:
        # Text such as the author's name is not used, so it may be in any encoding.
        with av.open(str(video), metadata_errors="replace") as container:
            if not container.streams.video:
                raise InputError(
                    f"{video}: holds no video stream; expected a video of the moving surface, "
                    "check that the right file is named."
                )
            stream = container.streams.video[0]
            if getattr(stream, "codec_context", None) is None:
                raise InputError(
                    f"{video}: names a codec that FFmpeg does not know; expected a video that "
                    "FFmpeg decodes, check its header or convert it to another codec."
                )
            stream.thread_type = "AUTO"
            stream.thread_count = 2
            yield container
    # A damaged header gives impossible sizes and times, which raise arithmetic errors: also an
    # error of the file.
    except (av.FFmpegError, EOFError, ValueError, ArithmeticError) as error:
        raise InputError(
            f"{video}: cannot be read as a video to its end ({reason(error)}); expected a whole "
            "file that FFmpeg reads, copy or record it again."
        ) from error


def reason(error: BaseException) -> str:
    """Why a file cannot be read, in the system's words."""
    return str(getattr(error, "strerror", None) or error).strip().rstrip(".").lower()


def declared_end_s(stream: Any, container: InputContainer) -> float | None:
    """The end of the video by its header [s], on the clock of the presentation times."""
    if stream.duration is not None and stream.time_base is not None:
        return float(((stream.start_time or 0) + stream.duration) * stream.time_base)
    if container.duration is not None:
        return float((container.start_time or 0) + container.duration) / 1e6
    return None


@dataclass(frozen=True)
class Header:
    """The data of a video file without decoding it.

    The number of pictures; the unit of their times [s]; the declared frame rate, if any; the name
    of the codec where it predicts pictures from earlier ones, with loss; the end that the file
    declares [s] where it stops much earlier, else None; whether it says that it is interlaced;
    whether it ends within a packet; the bits of a sample of its pictures; the number of pixels.
    """

    count: int
    tick_s: float
    declared_hz: float | None
    predicting: str | None
    missing_until_s: float | None = None
    interlaced: bool = False
    cut: bool = False
    bits: int = 8
    pixels: int = 0


def check(video: Path) -> Header:
    """Read a video through without decoding it.

    Raises ``InputError`` for a file that cannot be read or holds fewer than 50 pictures. A file
    that breaks off, or whose header declares more than it holds, counts up to there.
    """
    with opened(video) as container:
        stream = container.streams.video[0]
        base = float(stream.time_base or 0)
        stamps, broken = _stamps(container, stream)
        last_s = base * max((stamp for stamp in stamps if stamp is not None), default=0)
        end_s = declared_end_s(stream, container)
        frame_s = (end_s or last_s) / max(len(stamps), 1)
        early = end_s is not None and end_s - last_s > max(4.0 * frame_s, 0.1)
        codec, rate = stream.codec_context.codec, stream.base_rate
        sample = stream.codec_context.format
        predicting = codec.name if codec.lossy and not codec.intra_only else None
        header = Header(
            len(stamps),
            base,
            float(rate) if rate else None,
            predicting,
            (end_s or last_s) if broken or (early and not _whole(stream, len(stamps))) else None,
            stream.codec_context.field_order > _PROGRESSIVE,
            _cut(video, container),
            sample.components[0].bits if sample is not None else 8,
            stream.codec_context.width * stream.codec_context.height,
        )
    if header.count < MIN_FRAMES:
        raise InputError(
            f"{video}: holds {header.count} frames; expected at least {MIN_FRAMES}, record longer."
        )
    return header


def _stamps(container: InputContainer, stream: Any) -> tuple[list[int | None], bool]:
    """Presentation times [ticks] of a file's pictures, and whether an error ended them."""
    import av

    stamps: list[int | None] = []
    try:
        stamps.extend(packet.pts for packet in container.demux(stream) if packet.size)
    except av.FFmpegError:
        if len(stamps) < MIN_FRAMES:
            raise
        return stamps, True
    return stamps, False


def _cut(video: Path, container: InputContainer) -> bool:
    """Whether a transport stream, which declares no length, ends within a packet: its packets are
    all of one size, by the kind of the stream."""
    size = video.stat().st_size
    return container.format.name == "mpegts" and all(size % packet for packet in _TRANSPORT)


def _whole(stream: Any, count: int) -> bool:
    """Whether a file whose header counts its pictures holds as many: only its length is wrong."""
    return 0 < int(stream.frames or 0) <= count
