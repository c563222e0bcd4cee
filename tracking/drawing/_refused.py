"""What the program saw in a video that it did not track: changes, pivot and outline, on a grid."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from servosight.models.core import Array, Image

_FOUND = (80, 220, 90)
_CHANGE = (60, 60, 240)
_GRID = (150, 150, 150)
_LEAST_CHANGE = 12.0  # grey levels
_STEPS_PX = (25, 50, 100, 200, 500, 1000)
_LINES = 8


def refusal_picture(
    images: Sequence[Image],
    pivot_px: tuple[float, float] | None = None,
    outline_px: Array | None = None,
) -> Image:
    """The first frame in grey, what changes over the frames in red, and a grid in pixels.

    ``pivot_px`` and ``outline_px`` (points, 2) are those found, if any, with the options that give
    the same. Returns (height, width, 3), blue-green-red.
    """
    first = images[0]
    canvas = np.repeat((0.5 * first + 40.0).astype(np.uint8)[:, :, None], 3, axis=2)
    change = _change(images)
    shade = np.clip(change / 60.0, 0.0, 0.7)[:, :, None] * (change > _LEAST_CHANGE)[:, :, None]
    canvas = np.asarray(canvas * (1.0 - shade) + shade * np.array(_CHANGE), np.uint8)
    _rule(canvas)
    if outline_px is not None:
        line = np.round(outline_px).astype(np.int32)
        cv2.polylines(canvas, [line], True, _FOUND, 2, cv2.LINE_AA)
        low, size = outline_px.min(0), np.ptp(outline_px, axis=0)
        box = ",".join(f"{v:.0f}" for v in (*low, *size))
        _write(canvas, f"--template {box}", np.array([low[0], low[1] - 6]), _FOUND)
    if pivot_px is not None:
        x, y = pivot_px
        at = (round(x), round(y))
        if abs(x) < 1e5 and abs(y) < 1e5:
            cv2.drawMarker(canvas, at, _FOUND, cv2.MARKER_CROSS, 24, 2, cv2.LINE_AA)
            _write(canvas, f"--pivot {x:.0f},{y:.0f}", np.array([x + 14, y]), _FOUND)
    return canvas


def _change(images: Sequence[Image]) -> Array:
    """By how much the grey level of each pixel varies over the frames; (height, width)."""
    smooth = [cv2.GaussianBlur(image, (0, 0), 1.5) for image in images]
    high, low = smooth[0].copy(), smooth[0].copy()
    for image in smooth[1:]:
        np.maximum(high, image, out=high)
        np.minimum(low, image, out=low)
    return np.asarray(high, np.float64) - low


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
    for shade, thick in (((20, 20, 20), 3), (colour, 1)):
        cv2.putText(
            canvas, words, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.45, shade, thick, cv2.LINE_AA
        )
