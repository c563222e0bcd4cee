"""Decoded pictures as they are meant to be seen: whole instead of interlaced, upright, in grey and
colour."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Image, InputError
from servosight.tracking.video._fields import FieldOrder

_LARGEST_SIDE_PX = 8192
# One picture a frame, of the field that was exposed first: its time is the frame's.
_DEINTERLACE = "mode=send_frame:deint=interlaced"
_DEINTERLACE_ALL = "mode=send_frame:deint=all:parity={}"
_CONVERTERS = threading.local()


def progressive(pictures: Iterator[Any], woven: FieldOrder | None = None) -> Iterator[Any]:
    """The same pictures, of interlaced ones the first field, its missing lines filled in.

    FFmpeg's ``yadif``; pictures that are not interlaced pass unchanged, unless all are ``woven`` of
    fields in that order, whatever the file says.
    """
    for picture in pictures:
        if woven is not None or picture.interlaced_frame:
            options = _DEINTERLACE if woven is None else _DEINTERLACE_ALL.format(woven.value)
            yield from _deinterlaced(picture, pictures, options)
            return
        yield picture


def _deinterlaced(first: Any, others: Iterator[Any], options: str) -> Iterator[Any]:
    import av
    from av.filter import Graph

    graph = Graph()
    source = graph.add_buffer(
        width=first.width, height=first.height, format=first.format, time_base=first.time_base
    )
    graph.link_nodes(source, graph.add("yadif", options), graph.add("buffersink")).configure()

    def ready() -> Iterator[Any]:
        while True:
            try:
                yield graph.pull()
            except (av.BlockingIOError, av.EOFError):
                return

    graph.push(first)
    yield from ready()
    for picture in others:
        graph.push(picture)
        yield from ready()
    graph.push(None)
    yield from ready()


def tag_deg(picture: Any) -> int:
    """By how much the file's tag turns a picture counter-clockwise [deg]: 0, 90, 180 or 270."""
    return int(round(picture.rotation / 90.0) % 4 * 90)


def upright(video: Path, index: int, picture: Any, shape: tuple[int, ...] | None = None) -> Image:
    """The picture in grey, turned as its tag says; rejected where its size cannot be used or is not
    ``shape``, the first's.

    Before it is converted: a damaged header may claim more than fits into memory.
    """
    turns = tag_deg(picture) // 90
    width, height = (picture.width, picture.height)[:: -1 if turns % 2 else 1]
    if min(width, height) < 32 or max(width, height) > _LARGEST_SIDE_PX:
        raise InputError(
            f"{video}: pictures of {width} x {height} px; expected 32 to {_LARGEST_SIDE_PX} px a "
            "side, scale the video."
        )
    if shape is not None and (height, width) != shape:
        raise InputError(
            f"{video}: frame {index} is {width} x {height} px where the first is {shape[1]} x "
            f"{shape[0]}; expected one size, cut the file there."
        )
    image = _converted(picture, "gray")
    return np.ascontiguousarray(np.rot90(image, turns)) if turns else image


def colours(picture: Any) -> Image:
    """By how much blue and red differ from the grey, turned as ``upright`` does; uint8 (2, height,
    width), 128 where there is no colour.

    Of the size of the grey, although most files hold them at half of it.
    """
    turns = tag_deg(picture) // 90
    planes = _converted(picture, "yuv444p")[1:]
    return np.ascontiguousarray(np.rot90(planes, turns, axes=(1, 2))) if turns else planes


def _converted(picture: Any, pixels: str) -> Image:
    """A picture's planes in a pixel format of FFmpeg's.

    Each thread keeps its converters: to set one up takes longer than to convert 640 x 480 pixels.
    """
    from av.video.reformatter import VideoReformatter

    kept = vars(_CONVERTERS)
    if pixels not in kept:
        kept[pixels] = VideoReformatter()
    image: Image = kept[pixels].reformat(picture, format=pixels).to_ndarray()
    return image
