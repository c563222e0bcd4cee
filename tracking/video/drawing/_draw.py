"""The tracker's result drawn on the video's pictures: overlay video and contact sheet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import (
    MARK,
    Array,
    FrameProgress,
    Image,
    InputError,
    marked_png,
    new_file,
    write_bytes,
)
from servosight.tracking.core import Flag, Track, outline_at, turned
from servosight.tracking.video import Frame, frames

Colours = Image

COLOURS = ((80, 220, 90), (240, 170, 60))
"""Of each part, blue-green-red: the surface, then the horn."""
NAMES = ("surface", "horn")
_ROD = (200, 120, 230)
_DOUBTFUL = (60, 60, 240)
_PAPER, _INK = (28, 28, 28), (235, 235, 235)
_SHIFT = 4  # bits of a pixel's fraction that OpenCV draws with
_LINE_PX = 18
_TICK = Fraction(1, 90_000)
_CONTAINERS = (".mp4", ".mkv", ".mov")
_SHEET_FRAMES, _SHEET_COLUMNS = 12, 3
_CELL_PX = 480


def caption(track: Track, index: int) -> str:
    """Angle, sigma and flags of a frame."""
    flags = ", ".join(str(flag.name) for flag in Flag if track.flags[index] & flag)
    angle, sigma = track.angle_deg[index], track.sigma_deg[index]
    words = f"{angle:+9.4f} deg  sigma {sigma:.2g}  {flags.lower().replace('_', ' ')}"
    return words.rstrip()


def annotated(image: Image, tracks: Sequence[Track], index: int) -> Colours:
    """A frame with each part's outline, pivot and angle line, and a line of text for each below.

    Of two parts, with their names and the rod between them.

    The text has rows of its own, so that it hides nothing: (height + room, width, 3) uint8, both
    even. The colour is red where a flag is set.
    """
    height, width = image.shape
    room = _LINE_PX * (len(tracks) + 1)
    canvas = np.full((height + room + (height + room) % 2, width + width % 2, 3), _PAPER, np.uint8)
    canvas[:height, :width] = image[:, :, None]
    _text(canvas, f"frame {index}   {tracks[0].time_s[index]:.5f} s", height, 0)
    for row, (track, colour) in enumerate(zip(tracks, COLOURS, strict=False), start=1):
        shown = _DOUBTFUL if track.flags[index] else colour
        _draw(canvas[:height, :width], track, float(track.angle_deg[index]), shown)
        name = f"{NAMES[row - 1]:<9}" if len(tracks) > 1 else ""
        _text(canvas, name + caption(track, index), height, row, shown)
    if len(tracks) > 1:
        _draw_rod(canvas[:height, :width], tracks[0], tracks[1], index)
    return canvas


def _draw_rod(canvas: Colours, surface: Track, horn: Track, index: int) -> None:
    """The rod's line from pin to pin, where one was found."""
    rod = surface.linkage.rod if surface.linkage is not None else None
    if rod is None:
        return
    ends = []
    for part, pin in ((surface, rod.surface_px), (horn, rod.horn_px)):
        angle_rad = float(np.deg2rad(part.angle_deg[index]))
        (end,) = turned(np.array([pin]), part.pivot_px, angle_rad)
        ends.append(_place(end))
        cv2.circle(canvas, ends[-1], 3 << _SHIFT, _ROD, 1, cv2.LINE_AA, _SHIFT)
    cv2.line(canvas, ends[0], ends[1], _ROD, 1, cv2.LINE_AA, _SHIFT)


def _draw(canvas: Colours, track: Track, angle_deg: float, colour: tuple[int, ...]) -> None:
    outline = outline_at(track, angle_deg)
    pivot = np.array(track.pivot_px)
    # The angle line leads from the pivot to the outline's farthest point at angle zero.
    far = int(np.argmax(np.hypot(*(track.outline_px - pivot).T)))
    for tip, shade in ((outline_at(track, 0.0)[far], (150, 150, 150)), (outline[far], colour)):
        cv2.line(canvas, _place(pivot), _place(tip), shade, 1, cv2.LINE_AA, _SHIFT)
    cv2.polylines(canvas, [_places(outline)], True, colour, 1, cv2.LINE_AA, _SHIFT)
    cv2.circle(canvas, _place(pivot), 4 << _SHIFT, colour, 1, cv2.LINE_AA, _SHIFT)


def _places(points_px: Array) -> NDArray[np.int32]:
    return np.round(points_px * (1 << _SHIFT)).astype(np.int32)


def _place(point_px: Array) -> tuple[int, int]:
    x, y = _places(point_px)
    return int(x), int(y)


def _text(
    canvas: Colours, words: str, below: int, row: int, colour: tuple[int, ...] = _INK
) -> None:
    at = (6, below + _LINE_PX * (row + 1) - 5)
    # A small picture is narrower than the words: shrink them to it.
    size = 0.45
    (wide, _), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, size, 1)
    size *= min(1.0, (canvas.shape[1] - 12) / max(wide, 1))
    cv2.putText(canvas, words, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)


def write_overlay(
    path: Path, tracks: Sequence[Track], progress: FrameProgress | None = None
) -> None:
    """Draw the tracks of one video into an H.264 video with the same presentation times.

    Streamed, and written completely or not at all. InputError for another ending than .mp4,
    .mkv or .mov.
    """
    import av

    if path.suffix.lower() not in _CONTAINERS:
        raise InputError(
            f"{path}: does not have the ending of a video file; expected one of "
            f"{', '.join(_CONTAINERS)}, rename it."
        )
    source = frames(tracks[0].video)
    with new_file(path) as place, av.open(str(place), "w") as container:
        stream = container.add_stream("libx264", rate=_rate(tracks[0]))
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "20", "preset": "veryfast"}
        stream.codec_context.time_base = stream.time_base = _TICK
        container.metadata["comment"] = MARK
        start_s: float | None = None
        for frame in source:
            picture = av.VideoFrame.from_ndarray(
                annotated(frame.image, tracks, frame.index), format="bgr24"
            )
            if start_s is None:
                start_s = frame.time_s
                stream.width, stream.height = picture.width, picture.height
            picture.pts, picture.time_base = round((frame.time_s - start_s) / _TICK), _TICK
            container.mux(stream.encode(picture))
            if progress is not None:
                progress(frame.index + 1, tracks[0].frames)
        container.mux(stream.encode())


def _rate(track: Track) -> Fraction:
    """The usual frame rate, for players that need one."""
    return Fraction(1.0 / float(np.median(np.diff(track.time_s)))).limit_denominator(1000)


def write_sheet(path: Path, tracks: Sequence[Track], progress: FrameProgress | None = None) -> None:
    """Write a PNG of the dozen frames with the largest sigma, in the order of their times.

    Frames near one of larger sigma are left out: otherwise one bad stretch would fill the sheet.
    Raises ``InputError`` for another ending than .png.
    """
    if path.suffix.lower() != ".png":
        raise InputError(f"{path}: expected a name that ends in .png; rename it.")
    wanted = doubtful(tracks)
    cells = [
        _cell(annotated(frame.image, tracks, frame.index))
        for frame in _chosen(tracks[0].video, wanted, progress)
    ]
    cells += [np.full_like(cells[0], _PAPER)] * (-len(cells) % _SHEET_COLUMNS)
    rows = [
        np.hstack(cells[start : start + _SHEET_COLUMNS])
        for start in range(0, len(cells), _SHEET_COLUMNS)
    ]
    write_picture(path, np.vstack(rows))


def write_picture(path: Path, picture: Image) -> None:
    """Write a picture (height, width, 3), blue-green-red, as a marked PNG."""
    good, data = cv2.imencode(".png", picture)
    assert good
    write_bytes(path, marked_png(data.tobytes()))


def doubtful(tracks: Sequence[Track], count: int = _SHEET_FRAMES) -> list[int]:
    """The frames with the largest sigma relative to each part's median; rising, not adjacent."""
    doubt = np.max([track.sigma_deg / np.median(track.sigma_deg) for track in tracks], axis=0)
    room = max(len(doubt) // (4 * count), 1)
    found: list[int] = []
    for index in np.argsort(-doubt, kind="stable"):
        if all(abs(int(index) - other) > room for other in found):
            found.append(int(index))
        if len(found) == count:
            break
    return sorted(found)


def _chosen(video: Path, wanted: Sequence[int], progress: FrameProgress | None) -> Iterator[Frame]:
    for frame in frames(video):
        if progress is not None:
            progress(frame.index + 1, wanted[-1] + 1)
        if frame.index in wanted:
            yield frame
        if frame.index == wanted[-1]:
            return


def _cell(picture: Colours) -> Colours:
    """A picture at the sheet's size, with a line about it."""
    scale = _CELL_PX / picture.shape[1]
    size = (_CELL_PX, round(picture.shape[0] * scale))
    how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
    small = cv2.resize(picture, size, interpolation=how)
    return np.asarray(cv2.copyMakeBorder(small, 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=(90,) * 3))
