"""What the program saw in a video that it did not track: changes, pivot and outline, on a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import median_filter

from servosight.models.core import Array, Image, Single
from servosight.tracking.core import Box, known_median
from servosight.tracking.video.drawing._canvas import Canvas, Colour

_FOUND = (80, 220, 90)
_OTHERS = ((60, 200, 250), (250, 190, 90), (220, 120, 230))
_POINTED = (255, 255, 255)
_CHANGE = (60, 60, 240)
_GRID = (150, 150, 150)
_LEAST_CHANGE = 12.0  # grey levels
_CROSS = 12.0
_LOOKED_AT_PX = 960  # the longer side: what is smaller in large pictures is no part
_CELLS, _AROUND = 40, 21  # of the longer side; what is wider than half of it is light
_STEPS_PX = (10, 25, 50, 100, 200, 500, 1000)
_LINES = 8
_LEAST_AREA_PX = 144
_EVERY, _ROUNDS, _FAR = 8, 4, 3.0
"""The light of a picture: rows and columns looked at, fits, and medians that belong to it."""


@dataclass(frozen=True)
class SeenPart:
    """A part that was found: its pivot x, y [px], and its outline (points, 2) on the picture."""

    pivot_px: tuple[float, float]
    outline_px: Array


def refusal_picture(
    images: Sequence[Image], parts: Sequence[SeenPart] = (), at_s: float | None = None,
    pointed: SeenPart | None = None,
) -> Image:  # fmt: skip
    """The first picture in grey, what changes over them in red, and a grid in pixels.

    ``parts`` are those found, if any, the best first, with the options that give them; without any,
    what stands out on this picture is framed. ``at_s`` is its time in the video, None for the first
    frame's; ``pointed`` is where the user points. Returns (height, width, 3), blue-green-red.
    """
    first = images[0]
    grey = np.repeat((0.5 * first + 40.0).astype(np.uint8)[:, :, None], 3, axis=2)
    scale = min(1.0, _LOOKED_AT_PX / max(first.shape))
    small = [_reduced(one, scale) for one in images]
    seen = [_in_light_of(small[0], one) for one in small]
    change = np.asarray(cv2.resize(_change(seen), first.shape[::-1]), np.float64)
    shade = np.clip(change / 60.0, 0.0, 0.7)[:, :, None] * (change > _LEAST_CHANGE)[:, :, None]
    canvas = Canvas.of(np.asarray(grey * (1.0 - shade) + shade * np.array(_CHANGE), np.uint8))
    _rule(canvas, first.shape)
    if at_s is not None and at_s > 0.0:
        canvas.write(f"this frame: --at {at_s:.3f}", (6, first.shape[0]), _FOUND)
    colours = [_FOUND, *(_OTHERS[n % len(_OTHERS)] for n in range(len(parts) - 1))]
    for part, colour in reversed(list(zip(parts, colours, strict=False))):
        _mark(canvas, part, colour)
    if pointed is not None:
        _mark(canvas, pointed, _POINTED)
        canvas.write("pointed at", _beside(canvas, pointed), _POINTED)
    for number, (part, colour) in enumerate(zip(parts, colours, strict=False), start=1):
        _name(canvas, part, number if len(parts) > 1 else None, colour, first.shape)
    if not parts:
        box = _standing_out(seen, scale)
        if box is not None:
            x, y, width, height = box
            around = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
            canvas.line(around, _OTHERS[0], closed=True)
            canvas.write(f"--template {x},{y},{width},{height}", (x, y - 6), _OTHERS[0])
    return canvas.pixels


def _reduced(image: Image, scale: float) -> Image:
    if scale == 1.0:
        return image
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.uint8)


def _mark(canvas: Canvas, part: SeenPart, colour: Colour) -> None:
    """A part's outline and pivot."""
    if len(part.outline_px):
        canvas.line(part.outline_px, colour, closed=True, thick=2)
    canvas.cross(np.array(part.pivot_px), _CROSS, colour)


def _name(
    canvas: Canvas, part: SeenPart, number: int | None, colour: Colour, shape: tuple[int, ...]
) -> None:
    """The options that give a part of a picture of this shape (height, width)."""
    outline = part.outline_px
    if len(outline):
        low = np.clip(np.floor(outline.min(0)), 0, None)
        size = np.floor(np.minimum(outline.max(0), np.array(shape[1::-1])) - low)
        if (size > 0).all():
            box = ",".join(f"{v:.0f}" for v in (*low, *size))
            canvas.write(f"--template {box}", low - (0, 6), colour)
    x, y = part.pivot_px
    picked = "" if number is None else f"--pick {number} or "
    canvas.write(f"{picked}--pivot {x:.0f},{y:.0f}", _beside(canvas, part), colour)


def _beside(canvas: Canvas, part: SeenPart) -> tuple[float, float]:
    """Where words stand on a part's pivot."""
    x, y = part.pivot_px
    return x + _CROSS * canvas.weight / canvas.times, y


def _standing_out(images: Sequence[Image], scale: float) -> Box | None:
    """The largest piece of the first picture that differs from their median, where it is drawn; the
    pictures, in one light, are ``scale`` times as large."""
    usual = known_median(np.stack(images))
    away = np.abs(_evenly(np.asarray(images[0] - usual, np.float32)))
    away = cv2.GaussianBlur(away, (0, 0), 2.0)
    mask = cv2.dilate((away > _LEAST_CHANGE).astype(np.uint8), np.ones((5, 5), np.uint8))
    count, _, stats, _ = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return None
    # What reaches the border, as that of a bar beside a held camera's picture, is no whole part.
    ends = np.array(mask.shape[::-1])
    within = (stats[1:, :2] > 0).all(1) & (stats[1:, :2] + stats[1:, 2:4] < ends).all(1)
    areas = stats[1:, cv2.CC_STAT_AREA]
    chosen = np.where(within & (areas >= _LEAST_AREA_PX), areas + areas.max(), areas)
    *box, area = stats[1 + int(np.argmax(chosen))]
    x, y, width, height = (round(float(side) / scale) for side in box)
    return (x, y, width, height) if area >= _LEAST_AREA_PX else None


def _change(images: Sequence[Image]) -> Single:
    """By how much the grey level of each pixel varies over pictures in one light, beyond what most
    of the picture does, as by noise; (height, width)."""
    smooth = [cv2.GaussianBlur(one.astype(np.float32), (0, 0), 1.5) for one in images]
    high = low = np.zeros(smooth[0].shape, np.float32)
    for one in smooth:
        away = _evenly(one - smooth[0])
        high, low = np.maximum(high, away), np.minimum(low, away)
    spread = high - low
    return np.asarray(np.maximum(spread - np.median(spread), 0.0), np.float32)


def _evenly(change: Single) -> Single:
    """A difference of two pictures (height, width) without what changes alike over a wide part of
    them, as a shadow or a lamp does: the median of what is around each place."""
    height, width = change.shape
    cell = max(1, max(height, width) // _CELLS)
    size = (max(1, width // cell), max(1, height // cell))
    coarse = cv2.resize(change, size, interpolation=cv2.INTER_AREA)
    wide = median_filter(coarse, size=_AROUND, mode="nearest")
    return np.asarray(
        change - cv2.resize(wide, (width, height), interpolation=cv2.INTER_LINEAR), np.float32
    )


def _in_light_of(first: Image, image: Image) -> Image:
    """A picture with gain and offset by which most of it is as the first one."""
    wanted, given = (one[::_EVERY, ::_EVERY].astype(np.float64).ravel() for one in (first, image))
    line, use = np.array([1.0, np.median(wanted - given)]), np.ones(given.size, bool)
    for _ in range(_ROUNDS):
        if np.ptp(given[use]) < _LEAST_CHANGE:  # no contrast that tells a gain
            break
        line = np.polyfit(given[use], wanted[use], 1)
        away = np.abs(wanted - np.polyval(line, given))
        use = away <= _FAR * float(np.median(away)) + 1.0
    return np.asarray(np.clip(np.polyval(line, image), 0.0, 255.0), np.uint8)


def _rule(canvas: Canvas, shape: tuple[int, ...]) -> None:
    """Lines at round coordinates, with their numbers, on a picture of a shape (height, width)."""
    height, width = shape
    step = next((s for s in _STEPS_PX if s * _LINES >= max(height, width)), _STEPS_PX[-1])
    for x in range(step, width, step):
        canvas.line(np.array([[x, 0], [x, height]]), _GRID)
        canvas.write(str(x), (x + 2 / canvas.times, 0), _GRID)
    for y in range(step, height, step):
        canvas.line(np.array([[0, y], [width, y]]), _GRID)
        canvas.write(str(y), (0, y - 3 / canvas.times), _GRID)
