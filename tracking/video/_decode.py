"""Decoding packet by packet: pictures with rising times, past what is damaged in a file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import InputError
from servosight.tracking.video._container import is_timed, picture_rate
from servosight.tracking.video._fields import FieldOrder
from servosight.tracking.video._upright import progressive

if TYPE_CHECKING:
    from av.container import InputContainer

_IN_A_ROW = 30  # packets that cannot be decoded: what comes after them is not looked for
_LEFT_OUT, _LEFT_OUT_SHARE = 10, 0.1  # of pictures whose time does not rise: more is no damage


@dataclass(frozen=True)
class TimedPicture:
    """A decoded picture (PyAV's), its presentation time [s], and how many before it, after the last
    one, could not be used."""

    picture: Any
    time_s: float
    missing: int


class _Packets:
    """The times of packets whose pictures have not come out yet, None where a damaged one has none.

    Some packets are not meant to be shown: only once one could not be decoded, those that never
    come out are lost.
    """

    def __init__(self) -> None:
        self.waiting: list[Fraction | None] = []
        self.damaged = False

    def lost_before(self, stamp: Fraction | None) -> int:
        """How many are lost before a picture of this time; they wait no longer."""
        later = [s for s in self.waiting if s is not None and stamp is not None and s >= stamp]
        lost = len(self.waiting) - len(later)
        self.waiting = [s for s in later if s != stamp]
        return lost if self.damaged else 0


def timed_pictures(
    video: Path, container: InputContainer, stream: Any, least: int,
    woven: FieldOrder | None = None,
) -> Iterator[TimedPicture]:  # fmt: skip
    """The pictures up to the file's end or to 30 packets in a row that cannot be decoded.

    Times are presentation times (pts x time base); in a file without them pictures are counted by
    the rate that its codec states. Of pictures that are ``woven`` of two fields the first field is
    given. A packet that cannot be decoded is left out, and so is a picture
    whose time does not rise, as one that the decoder concealed. Raises FFmpeg's error where less
    than ``least`` pictures come before it, and ``InputError`` where the times of many pictures do
    not rise.
    """
    rate, timed = picture_rate(stream), is_timed(container)
    packets = _Packets()
    count = left_out = in_a_row = 0
    last_s, stamped = -math.inf, False
    for picture in progressive(_decoded(container, stream, least, packets), woven):
        stamp = _stamp(picture) if timed else None
        time_s = float(stamp) if stamp is not None else last_s
        if stamp is None and not stamped:
            if not rate:
                raise InputError(
                    f"{video}: frame {count} has neither a presentation time nor a frame rate; "
                    "expected one of them, remux the file or give the times in a frames.csv."
                )
            time_s = float(count / rate)
        if time_s <= last_s:
            left_out, in_a_row = left_out + 1, in_a_row + 1
            if left_out > max(_LEFT_OUT, _LEFT_OUT_SHARE * count):
                raise InputError(
                    f"{video}: frame {count} has the time {time_s:.6f} s, not after the frame "
                    f"before it ({last_s:.6f} s), and so have {left_out - 1} others; expected "
                    "rising presentation times, remux the file so that they rise."
                )
            continue
        yield TimedPicture(picture, time_s, max(packets.lost_before(stamp), in_a_row))
        last_s, stamped, in_a_row = time_s, stamped or stamp is not None, 0
        count += 1


def _stamp(of: Any) -> Fraction | None:
    """The presentation time [s] of a packet or picture, where it has one."""
    return of.pts * of.time_base if of.pts is not None and of.time_base is not None else None


def _decoded(
    container: InputContainer, stream: Any, least: int, packets: _Packets
) -> Iterator[Any]:
    """Pictures as they are decoded; ``packets`` learns of each packet before."""
    import av

    count = in_a_row = 0
    error: av.FFmpegError | None = None
    try:
        for packet in container.demux(stream):
            stamp = _stamp(packet)
            packets.waiting += [stamp] if stamp is not None else []
            try:
                pictures = packet.decode()
            except av.FFmpegError as damaged:
                error, packets.damaged, in_a_row = damaged, True, in_a_row + 1
                packets.waiting += [None] if stamp is None else []
                if in_a_row == _IN_A_ROW:
                    break
                continue
            in_a_row = 0
            yield from pictures
            count += len(pictures)
    except av.FFmpegError as ended:
        error = ended
    if error is not None and count < least:
        raise error
