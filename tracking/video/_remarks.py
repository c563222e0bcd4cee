"""What a user is told of a video file: its clock, its rate, what is missing, how it is stored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.tracking.video._container import Header
from servosight.tracking.video._fields import FieldOrder
from servosight.tracking.video._rate import varying_rate

_OFF_RATE = 0.02  # tolerated difference of the declared rate from the presentation times'
_EVEN = 0.1  # share of a frame time, and of frames, that an even rate may be off
_BITS = 8  # a sample, in which pictures are read
_BUFFERED = 4  # frames that a decoder may keep to itself at the end
_WOVEN = (
    "the pictures are woven of two fields, as of an interlaced video, although the file does not "
    "say so"
)
_NEAR_S = 0.1  # of time 0: B frames alone shift the first picture by less


def of_clock(header: Header, first_s: float) -> list[str]:
    """A sentence each where a file holds no times, and where they do not begin at 0."""
    notes = []
    if not header.timed:
        notes.append(
            f"the file holds no times, as a raw stream: {header.declared_hz:.4g} frames a second "
            "are taken, as its codec declares"
        )
    if abs(first_s) > _NEAR_S:
        notes.append(
            f"the file's times begin at {first_s:.3f} s, where a player may show 0: --at counts "
            "by the file's"
        )
    return notes


def of_rate(header: Header, stamps_s: Sequence[float]) -> list[str]:
    """A sentence each where the declared rate is not that of the presentation times (frames,), and
    where theirs varies."""
    notes = []
    step_s = np.diff(stamps_s)
    rate_hz = 1.0 / float(np.median(step_s))
    even = float(np.mean(np.abs(step_s * rate_hz - 1.0) < _EVEN)) > 1.0 - _EVEN
    declared_hz = header.declared_hz
    if even and declared_hz is not None and abs(declared_hz / rate_hz - 1.0) > _OFF_RATE:
        notes.append(
            f"the file declares {declared_hz:.4g} frames a second, and its presentation times "
            f"say {rate_hz:.4g}: the times are used; a video replayed slower or faster needs "
            "a frames.csv"
        )
    return notes + varying_rate(np.asarray(step_s), header.tick_s)


def of_missing(header: Header, stamps_s: Sequence[float], left_out: int) -> list[str]:
    """A sentence each where ``left_out`` pictures are, and where the file breaks off."""
    notes = []
    if left_out:
        notes.append(
            f"{left_out} of the file's pictures cannot be decoded or have a time that does not "
            "rise: they are left out, and the frames after them are flagged"
        )
    fewer = header.count - len(stamps_s) - left_out
    until_s = header.missing_until_s
    if until_s is not None or fewer > _BUFFERED:
        declared = f", and it declares {until_s:.3f} s" if until_s is not None else ""
        notes.append(
            f"the file's pictures can be read up to {stamps_s[-1]:.3f} s{declared}: the angle "
            "ends there"
        )
    elif header.cut:
        notes.append(
            f"the file ends within a packet, and so breaks off: the angle ends with its last "
            f"picture, at {stamps_s[-1]:.3f} s, which may be incomplete"
        )
    elif header.uncounted:
        notes.append(
            f"{header.uncounted} of the pictures that the file declares are missing: an AVI file "
            "counts pictures instead of times, so that all after a missing one are too early"
        )
    return notes


def of_pictures(
    header: Header, tag_deg: int, shape: tuple[int, ...], woven: FieldOrder | None = None
) -> list[str]:
    """A sentence each where pictures of this shape (height, width) are not used as they are stored;
    ``tag_deg`` is by how much a tag turns them counter-clockwise [deg], ``woven`` the order of
    fields that the file does not tell of."""
    notes = []
    if header.streams > 1:
        notes.append(
            f"the file holds {header.streams} video streams: the one of {shape[1]} x {shape[0]} px "
            "is measured"
        )
    if tag_deg:
        notes.append(
            f"a tag of the file turns its pictures by {tag_deg} deg counter-clockwise: "
            "options and results count the pixels of the picture as it is then seen"
        )
    if tag_deg % 180:
        notes.append(
            "the rows of the sensor are columns of the picture: a rolling shutter is not "
            "corrected, and sigma allows for it"
        )
    if header.interlaced or woven is not None:
        notes.append(
            ("the video is interlaced" if woven is None else _WOVEN)
            + ": the field that was exposed first is used of each frame, with half of the lines"
        )
    if header.bits > _BITS:
        notes.append(f"its pictures have {header.bits} bits a sample, of which {_BITS} are used")
    if header.predicting is not None:
        notes.append(
            f"{header.predicting} predicts pictures from earlier ones: pixels that were "
            "only copied are left out, and sigma includes the scatter from frame to frame, but "
            "not an error that lasts for many frames"
        )
    return notes
