"""Reading a video: streamed frames, in grey or with their colour, and their presentation times."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from servosight.models.core import Image, InputError
from servosight.tracking.video._container import (
    MIN_FRAMES,
    declared_end_s,
    is_timed,
    opened,
    picture_rate,
)
from servosight.tracking.video._decode import TimedPicture, timed_pictures
from servosight.tracking.video._fields import FieldOrder, changes
from servosight.tracking.video._upright import colours, tag_deg, upright

_PART = 10  # of so many frames the calmest is taken
_BEYOND_S = 0.1


@dataclass(frozen=True)
class Frame:
    """One decoded picture: its place in the file, presentation time [s], grey (height, width).

    ``sigma_px`` is the uncertainty of the camera's position, where its motion was removed;
    ``roll_rad`` by how much the picture had turned counter-clockwise with the camera before that;
    ``tag_deg`` by how much a tag of the file turned it counter-clockwise. ``colour`` (2, height,
    width) are its differences of colour Cb and Cr, None where they were not asked for. ``missing``
    is how many pictures of the file before it, after the frame before, could not be used.
    """

    index: int
    time_s: float
    image: Image
    sigma_px: float = 0.0
    tag_deg: int = 0
    roll_rad: float = 0.0
    colour: Image | None = None
    missing: int = 0


def frames(video: Path, coloured: bool = False, woven: FieldOrder | None = None) -> Iterator[Frame]:
    """Stream the pictures of a video in order, ``coloured`` ones with their colour; memory does not
    grow with its length. Of pictures that are ``woven`` of two fields the first one is used.

    Times are presentation times, the start of exposure. What is damaged is left out, as
    ``timed_pictures`` says. Raises ``InputError`` for a file that cannot be decoded, that changes
    its picture size, or whose time does not advance.
    """
    with opened(video) as (container, stream):
        shape: tuple[int, ...] | None = None
        for index, seen in enumerate(timed_pictures(video, container, stream, MIN_FRAMES, woven)):
            image = upright(video, index, seen.picture, shape)
            shape = image.shape
            colour = colours(seen.picture) if coloured else None
            yield Frame(
                index,
                seen.time_s,
                image,
                tag_deg=tag_deg(seen.picture),
                colour=colour,
                missing=seen.missing,
            )


def check_before_end(video: Path, at_s: float) -> None:
    """InputError where ``at_s`` [s] is beyond the end that the video declares, if it does."""
    with opened(video) as (container, stream):
        end_s = declared_end_s(stream, container)
    if end_s is not None and at_s > end_s + _BEYOND_S:
        raise InputError(
            f"{video}: --at {at_s:g} is beyond the end of the video, at {end_s:.3f} s; expected a "
            "time in the video."
        )


def frame_at(video: Path, at_s: float, woven: FieldOrder | None = None) -> Frame:
    """The picture whose presentation time is nearest to ``at_s`` [s]; InputError where the video
    has none near it."""
    best: Frame | None = None
    for frame in frames(video, woven=woven):
        if best is None and at_s < frame.time_s - _BEYOND_S:
            raise InputError(
                f"{video}: --at {at_s:g} is before the first frame, at {frame.time_s:.3f} s; "
                f"expected a time of the file, add {frame.time_s:.3f} s where a player counts "
                "from 0."
            )
        if best is not None and abs(frame.time_s - at_s) >= abs(best.time_s - at_s):
            return best
        best = frame
    assert best is not None
    if at_s > best.time_s + _BEYOND_S:
        raise InputError(
            f"{video}: --at {at_s:g} is beyond the last frame, at {best.time_s:.3f} s; expected a "
            "time in the video."
        )
    return best


def sample_frames(video: Path, count: int) -> list[Frame]:
    """About ``count`` pictures spread evenly over the video, with the first one first.

    Seeks, so that a long file costs no full pass; ``index`` is exact for the first frame only
    (others carry their rank in the sample).
    """
    with opened(video) as (container, stream):
        base = float(stream.time_base or Fraction(1, 1000))
        decoder = timed_pictures(video, container, stream, 1)
        first = next(decoder, None)
        if first is None:
            raise InputError(
                f"{video}: holds no readable frame; expected a video, record it again."
            )
        start_s = first.time_s
        image = upright(video, 0, first.picture)
        sampled = [Frame(0, start_s, image)]
        end_s = declared_end_s(stream, container)
        if end_s is None or first.picture.pts is None or end_s <= start_s:
            return sampled + _by_decoding(decoder, count, video)
        for target_s in np.linspace(start_s, end_s, count + 1)[1:-1]:
            if target_s <= sampled[-1].time_s:
                continue
            container.seek(int(target_s / base), stream=stream)
            for seen in timed_pictures(video, container, stream, 0):
                if seen.time_s >= target_s:
                    number = len(sampled)
                    sampled.append(Frame(number, seen.time_s, upright(video, number, seen.picture)))
                    break
        return [frame for frame in sampled if frame.image.shape == image.shape]


def stretches(
    video: Path, count: int, length: int, woven: FieldOrder | None = None
) -> Iterator[list[Frame]]:
    """``count`` runs of ``length`` neighbouring pictures, spread evenly over the video.

    ``index`` counts from the video's start, by the declared rate after the first run. Decodes what
    lies between them in a file that is short, declares no length or holds no times.
    """
    if _in_order(video, 2 * count * length):
        yield from _in_one_pass(video, count, length, woven)
        return
    last_s, shape = -np.inf, None
    for number in range(count):
        with opened(video) as (container, stream):
            base = float(stream.time_base or Fraction(1, 1000))
            rate = picture_rate(stream) or Fraction(0)
            end_s = declared_end_s(stream, container)
            assert end_s is not None
            start_s = float(stream.start_time or 0) * base
            target_s = start_s + (number / count) * (end_s - start_s)
            if number:
                container.seek(int(target_s / base), stream=stream)
            run: list[Frame] = []
            least = 0 if number else length
            for seen in timed_pictures(video, container, stream, least, woven):
                if seen.time_s >= max(target_s, last_s + 1e-9):
                    run.append(_of_run(video, seen, (seen.time_s - start_s) * float(rate), shape))
                    shape = run[-1].image.shape
                if len(run) == length:
                    break
        if run:
            last_s = run[-1].time_s
            yield run


def _in_order(video: Path, most: int) -> bool:
    """Whether a video is decoded as a whole rather than sought in: where it declares ``most``
    pictures at most, that costs less; without a length or times there is no place to seek."""
    with opened(video) as (container, stream):
        end_s = declared_end_s(stream, container)
        rate = picture_rate(stream)
        if end_s is None or not is_timed(container):
            return True
        return rate is not None and end_s * float(rate) <= most


def _last_s(video: Path) -> float:
    """The time of a video's last picture [s], from its packets."""
    with opened(video) as (container, stream):
        stamps = [packet.pts for packet in container.demux(stream) if packet.size]
        known = [stamp for stamp in stamps if stamp is not None]
        if known and is_timed(container):
            return float(max(known) * stream.time_base)
        return len(stamps) / float(picture_rate(stream) or 1)


def _in_one_pass(
    video: Path, count: int, length: int, woven: FieldOrder | None
) -> Iterator[list[Frame]]:
    """The runs of ``stretches`` from a video that is decoded once."""
    end_s = _last_s(video)
    with opened(video) as (container, stream):
        rate = picture_rate(stream) or Fraction(0)
        start_s = float(stream.start_time or 0) * float(stream.time_base or Fraction(1, 1000))
        starts_s = [start_s + (number / count) * (end_s - start_s) for number in range(count)]
        run: list[Frame] = []
        last_s, shape = -np.inf, None
        for seen in timed_pictures(video, container, stream, length, woven):
            if seen.time_s < max(starts_s[0], last_s + 1e-9):
                continue
            run.append(_of_run(video, seen, (seen.time_s - start_s) * float(rate), shape))
            shape = run[-1].image.shape
            if len(run) == length:
                yield run
                last_s, run, starts_s = seen.time_s, [], starts_s[1:]
                if not starts_s:
                    return
        if run:
            yield run


def _of_run(video: Path, seen: TimedPicture, place: float, shape: tuple[int, ...] | None) -> Frame:
    """The frame of a picture at about this ``place`` in the file."""
    index = round(place)
    image = upright(video, index, seen.picture, shape)
    return Frame(index, seen.time_s, image, tag_deg=tag_deg(seen.picture))


def calm_frames(runs: Iterable[list[Frame]]) -> list[Frame]:
    """Pictures of runs of neighbouring frames in which little moves, the first one first.

    Of each tenth or so of a second, the picture that is most like its neighbours: the least
    smeared, and under a rolling shutter the least sheared.
    """
    calm: list[Frame] = []
    for run in runs:
        if len(run) < 2:
            continue
        change = changes([frame.image for frame in run])
        unlike = np.maximum(np.append(change, change[-1:]), np.append(change[:1], change))
        if not calm:
            calm.append(run[0])
        for start in range(0, len(run), _PART):
            best = start + int(np.argmin(unlike[start : start + _PART]))
            if run[best].time_s > calm[-1].time_s:
                calm.append(run[best])
    return calm


def _by_decoding(decoder: Iterator[TimedPicture], count: int, video: Path) -> list[Frame]:
    """Thin a stream of unknown length to at most ``count``: halve the sample when it is full."""
    kept: list[Frame] = []
    stride = 4
    for index, seen in enumerate(decoder, start=1):
        if index % stride == 0:
            kept.append(Frame(index, seen.time_s, upright(video, index, seen.picture)))
            if len(kept) >= 2 * count:
                kept, stride = kept[1::2], 2 * stride
    return kept


def read_frame(video: Path, index: int) -> Image:
    """The grey picture number ``index`` (0 is the first), uint8 (height, width)."""
    for frame in frames(video):
        if frame.index == index:
            return frame.image
    raise InputError(
        f"{video}: has no frame {index}; expected a number from 0 to its last frame's."
    )
