"""The tracker's result drawn on the video's pictures: overlay video and contact sheet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from servosight.models.core import (
    MARK,
    FrameProgress,
    Image,
    InputError,
    marked_png,
    new_file,
    write_bytes,
)
from servosight.tracking.core import Flag, Track, outline_at, turned
from servosight.tracking.video import Frame, frames
from servosight.tracking.video.drawing._canvas import LINE_PX, Canvas, Colour

Colours = Image

COLOURS = ((80, 220, 90), (240, 170, 60))
"""Of each part, blue-green-red: the surface, then the horn."""
NAMES = ("surface", "horn")
_ROD = (200, 120, 230)
_DOUBTFUL = (60, 60, 240)
_PAPER, _INK = (28, 28, 28), (235, 235, 235)
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


def annotated(
    image: Image, tracks: Sequence[Track], index: int, times: float | None = None
) -> Colours:
    """A frame with each part's outline, pivot and angle line, and a line of text for each below.

    Of two parts, with their names and the rod between them.

    It is drawn ``times`` as large, by default enlarged where it is small. The text has rows of its
    own, so that it hides nothing: (height + room, width, 3) uint8, both even. The colour is red
    where a flag is set.
    """
    canvas = Canvas.of(image, times)
    lines = [(f"frame {index}   {tracks[0].time_s[index]:.5f} s", _INK)]
    for name, track, colour in zip(NAMES, tracks, COLOURS, strict=False):
        shown = _DOUBTFUL if track.flags[index] else colour
        _draw(canvas, track, float(track.angle_deg[index]), shown)
        lines.append(((f"{name:<9}" if len(tracks) > 1 else "") + caption(track, index), shown))
    if len(tracks) > 1:
        _draw_rod(canvas, tracks[0], tracks[1], index)
    height, width = canvas.pixels.shape[:2]
    line_px = round(LINE_PX * canvas.weight)
    room = line_px * len(lines)
    whole = np.full((height + room + (height + room) % 2, width + width % 2, 3), _PAPER, np.uint8)
    whole[:height, :width] = canvas.pixels
    below = Canvas(whole)
    for row, (words, shown) in enumerate(lines, start=1):
        below.write(words, (6, height + line_px * row - 5 * canvas.weight), shown)
    return whole


def _draw_rod(canvas: Canvas, surface: Track, horn: Track, index: int) -> None:
    """The rod's line from pin to pin, where one was found."""
    rod = surface.linkage.rod if surface.linkage is not None else None
    if rod is None:
        return
    ends = []
    for part, pin in ((surface, rod.surface_px), (horn, rod.horn_px)):
        angle_rad = float(np.deg2rad(part.angle_deg[index]))
        (end,) = turned(np.array([pin]), part.pivot_px, angle_rad)
        ends.append(end)
        canvas.ring(end, 3.0, _ROD)
    canvas.line(np.array(ends), _ROD)


def _draw(canvas: Canvas, track: Track, angle_deg: float, colour: Colour) -> None:
    outline = outline_at(track, angle_deg)
    pivot = np.array(track.pivot_px)
    # The angle line leads from the pivot to the outline's farthest point at angle zero.
    far = int(np.argmax(np.hypot(*(track.outline_px - pivot).T)))
    for tip, shade in ((outline_at(track, 0.0)[far], (150, 150, 150)), (outline[far], colour)):
        canvas.line(np.array([pivot, tip]), shade)
    canvas.line(outline, colour, closed=True)
    canvas.ring(pivot, 4.0, colour)


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
        _cell(frame.image, tracks, frame.index)
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


def _cell(image: Image, tracks: Sequence[Track], index: int) -> Colours:
    """A frame at the sheet's size, with a line about it."""
    drawn = annotated(image, tracks, index, _CELL_PX / image.shape[1])
    return np.asarray(cv2.copyMakeBorder(drawn, 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=(90,) * 3))
