"""A video file's container: opened or rejected in one sentence, and the data of its header."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from servosight.models.core import Array, InputError

if TYPE_CHECKING:
    from av.container import InputContainer

MIN_FRAMES = 50
_TRANSPORT = (188, 192, 204)  # bytes of a packet
_NO_TIMES = 0x80  # FFmpeg's AVFMT_NOTIMESTAMPS
_PROGRESSIVE = 1  # FFmpeg's order of fields: 0 is unknown, 2 to 5 are interlaced
_THREADS = 3  # of the decoder: pictures are measured beside it


@contextmanager
def opened(video: Path) -> Iterator[tuple[InputContainer, Any]]:
    """The file's container and its video stream; every error of FFmpeg becomes one sentence.

    Of several streams that with the largest pictures, as players choose; not a cover picture.
    """
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
            stream = max(container.streams.video, key=_choice)
            if getattr(stream, "codec_context", None) is None:
                raise InputError(
                    f"{video}: names a codec that FFmpeg does not know; expected a video that "
                    "FFmpeg decodes, check its header or convert it to another codec."
                )
            stream.thread_type = "AUTO"
            stream.thread_count = _THREADS
            yield container, stream
    # A damaged header gives impossible sizes and times, which raise arithmetic errors: also an
    # error of the file.
    except (av.FFmpegError, EOFError, ValueError, ArithmeticError) as error:
        raise InputError(
            f"{video}: cannot be read as a video to its end ({reason(error)}); expected a whole "
            "file that FFmpeg reads, copy or record it again."
        ) from error


def _choice(stream: Any) -> tuple[bool, int]:
    """The larger, the rather a stream is the video; of equal ones the first is taken."""
    codec = getattr(stream, "codec_context", None)
    return not _is_cover(stream), codec.width * codec.height if codec is not None else 0


def _is_cover(stream: Any) -> bool:
    """Whether a stream is but a picture that stands for the file."""
    from av.stream import Disposition

    return bool(stream.disposition & Disposition.attached_pic)


def is_timed(container: InputContainer) -> bool:
    """Whether a file holds times of its pictures: a raw stream, as of H.264 or MJPEG, does not.

    FFmpeg then takes 25 pictures a second, whatever was filmed.
    """
    return not container.format.flags & _NO_TIMES


def picture_rate(stream: Any) -> Fraction | None:
    """Pictures a second as the file says, where it does, first as its codec does."""
    rate: Fraction | None = stream.guessed_rate or stream.average_rate
    return rate


def reason(error: BaseException) -> str:
    """Why a file cannot be read, in the system's words."""
    return str(getattr(error, "strerror", None) or error).strip().rstrip(".").lower()


def declared_end_s(stream: Any, container: InputContainer) -> float | None:
    """The end of the video by its header [s], on the clock of the presentation times."""
    if stream.duration is not None and stream.time_base is not None:
        return float(((stream.start_time or 0) + stream.duration) * stream.time_base)
    # Matroska counts its length from time 0, wherever its first picture is.
    if container.duration is not None:
        return float(min(container.start_time or 0, 0) + container.duration) / 1e6
    return None


@dataclass(frozen=True)
class Header:
    """The data of a video file without decoding it.

    The number of pictures; the unit of their times [s] and the usual time between two; whether the
    file holds these times; the declared frame rate, if any; the name of the codec where it predicts
    pictures from earlier ones, with loss; the end that the file declares [s] where it stops much
    earlier, else None; whether it says that it is interlaced; whether it ends within a packet; the
    bits of a sample of its pictures; the number of pixels; how many videos there are; how many
    pictures are missing of those that an AVI file declares, which counts them instead of times.
    """

    count: int
    tick_s: float
    step_s: float
    timed: bool
    declared_hz: float | None
    predicting: str | None
    missing_until_s: float | None = None
    interlaced: bool = False
    cut: bool = False
    bits: int = 8
    pixels: int = 0
    streams: int = 1
    uncounted: int = 0


def check(video: Path) -> Header:
    """Read a video through without decoding it.

    Raises ``InputError`` for a file that cannot be read or holds fewer than 50 pictures. A file
    that breaks off, or whose header declares more than it holds, counts up to there.
    """
    with opened(video) as (container, stream):
        base, timed = float(stream.time_base or 0), is_timed(container)
        found = _read_through(container, stream)
        stamps = np.array(sorted(s for s in found.stamps if s is not None and timed), np.float64)
        last_s = base * float(stamps[-1]) if stamps.size else 0.0
        end_s = declared_end_s(stream, container)
        count = len(found.stamps)
        frame_s = (end_s or last_s) / max(count, 1)
        early = end_s is not None and end_s - last_s > max(4.0 * frame_s, 0.1)
        codec = stream.codec_context.codec
        rate = stream.base_rate if timed else stream.codec_context.framerate
        sample = stream.codec_context.format
        predicting = codec.name if codec.lossy and not codec.intra_only else None
        incomplete = found.broken or (early and not _whole(stream, count))
        header = Header(
            count,
            base,
            base * float(np.median(np.diff(stamps))) if stamps.size > 1 else np.inf,
            timed,
            float(rate) if rate else None,
            predicting,
            (end_s or last_s) if incomplete else None,
            stream.codec_context.field_order > _PROGRESSIVE,
            found.cut or _cut(video, container),
            sample.components[0].bits if sample is not None else 8,
            stream.codec_context.width * stream.codec_context.height,
            sum(not _is_cover(one) for one in container.streams.video),
            _uncounted(container, stream, stamps),
        )
    if header.count < MIN_FRAMES:
        whole = header.missing_until_s is None and not header.cut
        fix = "record longer" if whole else "the file breaks off, so copy it again"
        raise InputError(
            f"{video}: holds {header.count} of at least {MIN_FRAMES} expected frames; {fix}."
        )
    return header


@dataclass(frozen=True)
class _Packets:
    """Presentation times [ticks] of a file's pictures, without those that are cut off the
    beginning by an edit; whether an error ended them, and whether the last one is incomplete."""

    stamps: list[int | None]
    broken: bool
    cut: bool


def _read_through(container: InputContainer, stream: Any) -> _Packets:
    import av

    stamps: list[int | None] = []
    cut = False
    try:
        for packet in container.demux(stream):
            if packet.size and not packet.is_discard:
                stamps.append(packet.pts)
                cut = packet.is_corrupt
    except av.FFmpegError:
        if len(stamps) < MIN_FRAMES:
            raise
        return _Packets(stamps, True, cut)
    return _Packets(stamps, False, cut)


def _cut(video: Path, container: InputContainer) -> bool:
    """Whether a transport stream, which declares no length, ends within a packet: its packets are
    all of one size, by the kind of the stream."""
    size = video.stat().st_size
    return container.format.name == "mpegts" and all(size % packet for packet in _TRANSPORT)


def _uncounted(container: InputContainer, stream: Any, stamps: Array) -> int:
    """How many pictures an AVI file declares beyond its last stamp (pictures,) [ticks]: it counts
    them, empty ones included, in place of times."""
    if container.format.name != "avi" or not stamps.size:
        return 0
    return max(int(stream.frames) - 1 - int(stamps[-1]), 0)


def _whole(stream: Any, count: int) -> bool:
    """Whether a file whose header counts its pictures holds as many: only its length is wrong."""
    return 0 < int(stream.frames or 0) <= count
