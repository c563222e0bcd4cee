"""What the program saw in a video that it did not track: changes, pivot and outline, on a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.core import Box, known_median

_FOUND = (80, 220, 90)
_OTHERS = ((60, 200, 250), (250, 190, 90), (220, 120, 230))
_CHANGE = (60, 60, 240)
_GRID = (150, 150, 150)
_LEAST_CHANGE = 12.0  # grey levels
_STEPS_PX = (25, 50, 100, 200, 500, 1000)
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
    images: Sequence[Image], parts: Sequence[SeenPart] = (), at_s: float | None = None
) -> Image:
    """The first picture in grey, what changes over them in red, and a grid in pixels.

    ``parts`` are those found, if any, the best first, with the options that give them; without any,
    what stands out on this picture is framed. ``at_s`` is its time in the video, None for the first
    frame's. Returns (height, width, 3), blue-green-red.
    """
    first = images[0]
    canvas = np.repeat((0.5 * first + 40.0).astype(np.uint8)[:, :, None], 3, axis=2)
    change = _change(images)
    shade = np.clip(change / 60.0, 0.0, 0.7)[:, :, None] * (change > _LEAST_CHANGE)[:, :, None]
    canvas = np.asarray(canvas * (1.0 - shade) + shade * np.array(_CHANGE), np.uint8)
    _rule(canvas)
    for number, part in reversed(list(enumerate(parts, start=1))):
        _mark(canvas, part, number if len(parts) > 1 else None)
    if not parts:
        box = _standing_out(images)
        if box is not None:
            x, y, width, height = box
            cv2.rectangle(canvas, (x, y), (x + width, y + height), _OTHERS[0], 1)
            words = f"--template {x},{y},{width},{height}"
            _write(canvas, words, np.array([x, y - 6]), _OTHERS[0])
    if at_s is not None and at_s > 0.0:
        words = f"this frame: --at {at_s:.3f}"
        _write(canvas, words, np.array([6, canvas.shape[0] - 6]), _FOUND)
    return canvas


def _mark(canvas: Image, part: SeenPart, number: int | None) -> None:
    """A part's outline and pivot, with the options that give it."""
    colour = _FOUND if number in (None, 1) else _OTHERS[(number - 2) % len(_OTHERS)]
    outline = part.outline_px
    if len(outline):
        line = np.round(np.clip(outline, -1e5, 1e5)).astype(np.int32)
        cv2.polylines(canvas, [line], True, colour, 2, cv2.LINE_AA)
        low = np.clip(outline.min(0), 0, None)
        size = np.minimum(outline.max(0), np.array(canvas.shape[1::-1])) - low
        box = ",".join(f"{v:.0f}" for v in (*np.floor(low), *np.floor(size)))
        _write(canvas, f"--template {box}", np.array([low[0], low[1] - 6]), colour)
    x, y = part.pivot_px
    if max(abs(x), abs(y)) < 1e5:
        at = (round(x), round(y))
        cv2.drawMarker(canvas, at, colour, cv2.MARKER_CROSS, 24, 2, cv2.LINE_AA)
        picked = "" if number is None else f"--pick {number} or "
        _write(canvas, f"{picked}--pivot {x:.0f},{y:.0f}", np.array([x + 14, y]), colour)


def _standing_out(images: Sequence[Image]) -> Box | None:
    """The largest piece of the first picture that differs from their median."""
    usual = known_median(np.stack(images))
    away = cv2.GaussianBlur(np.abs(images[0] - usual), (0, 0), 2.0)
    mask = cv2.dilate((away > _LEAST_CHANGE).astype(np.uint8), np.ones((5, 5), np.uint8))
    count, _, stats, _ = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return None
    x, y, width, height, area = stats[1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))]
    return (int(x), int(y), int(width), int(height)) if area >= _LEAST_AREA_PX else None


def _change(images: Sequence[Image]) -> Array:
    """By how much the grey level of each pixel varies over the frames beyond the light of the whole
    picture; (height, width)."""
    smooth = [cv2.GaussianBlur(_in_light_of(images[0], one), (0, 0), 1.5) for one in images]
    high, low = smooth[0].copy(), smooth[0].copy()
    for image in smooth[1:]:
        np.maximum(high, image, out=high)
        np.minimum(low, image, out=low)
    return np.asarray(high, np.float64) - low


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


def _rule(canvas: Image) -> None:
    """Lines at round coordinates, with their numbers."""
    height, width = canvas.shape[:2]
    step = next((s for s in _STEPS_PX if s * _LINES >= max(height, width)), _STEPS_PX[-1])
    for x in range(step, width, step):
        cv2.line(canvas, (x, 0), (x, height), _GRID, 1)
        _write(canvas, str(x), np.array([x + 2, 12]), _GRID)
    for y in range(step, height, step):
        cv2.line(canvas, (0, y), (width, y), _GRID, 1)
        _write(canvas, str(y), np.array([2, y - 3]), _GRID)


def _write(canvas: Image, words: str, at: Array, colour: tuple[int, ...]) -> None:
    """Words that stay within the picture, over a dark edge."""
    height, width = canvas.shape[:2]
    (wide, high), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, 0.45, 1)
    x = int(np.clip(at[0], 2, max(width - wide - 2, 2)))
    y = int(np.clip(at[1], high + 2, height - 4))
    # A thick text is wider, so that the edge is the same text beside itself.
    edge = [((20, 20, 20), dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    for shade, dx, dy in [*edge, (colour, 0, 0)]:
        at_px = (x + dx, y + dy)
        cv2.putText(canvas, words, at_px, cv2.FONT_HERSHEY_SIMPLEX, 0.45, shade, 1, cv2.LINE_AA)
