"""A picture to draw on, with lines and letters that can be read whatever its size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from servosight.models.core import Array, Image

LINE_PX = 18
"""The height of a line of words, in pictures of the usual size."""

_LEAST_PX, _USUAL_PX = 320, 1280  # the longer side: smaller is enlarged, beyond lines are thicker
_LETTERS = 0.45
_SHIFT = 4  # bits of a pixel's fraction that OpenCV draws with
_FARTHEST_PX = 1e5

Colour = tuple[int, ...]


def enlarged(longer_px: int) -> int:
    """How many times as large a picture with this longer side is drawn."""
    return max(1, -(-_LEAST_PX // longer_px))


@dataclass(frozen=True)
class Canvas:
    """``pixels`` (height, width, 3), blue-green-red, ``times`` as large as the picture drawn on.

    Places are pixels of that picture. ``written`` holds what words cover: x and y from, to.
    """

    pixels: Image
    times: float = 1.0
    written: list[tuple[int, int, int, int]] = field(default_factory=list)

    @classmethod
    def of(cls, picture: Image, times: float | None = None) -> Canvas:
        """From a picture (height, width[, 3]), drawn as large as it can be read where ``times`` is
        None."""
        by = enlarged(max(picture.shape[:2])) if times is None else times
        if by != 1.0:
            height, width = picture.shape[:2]
            how = cv2.INTER_AREA if by < 1.0 else cv2.INTER_CUBIC
            picture = np.asarray(
                cv2.resize(picture, (round(by * width), round(by * height)), interpolation=how),
                np.uint8,
            )
        coloured = picture if picture.ndim == 3 else np.repeat(picture[:, :, None], 3, axis=2)
        return cls(np.ascontiguousarray(coloured), by)

    @property
    def weight(self) -> float:
        """Of lines and letters: 1, more in large pictures, which are seen reduced."""
        return max(1.0, float(max(self.pixels.shape[:2])) / _USUAL_PX)

    @property
    def _thick(self) -> int:
        return round(self.weight)

    def line(self, points_px: Array, colour: Colour, closed: bool = False, thick: int = 1) -> None:
        """Through points (n, 2)."""
        far = np.clip(points_px, -_FARTHEST_PX, _FARTHEST_PX)
        places = np.round(((far + 0.5) * self.times - 0.5) * (1 << _SHIFT)).astype(np.int32)
        cv2.polylines(
            self.pixels, [places], closed, colour, thick * self._thick, cv2.LINE_AA, _SHIFT
        )

    def ring(self, at_px: Array, radius: float, colour: Colour) -> None:
        """About a point (2,), of a radius that does not depend on the enlargement."""
        turn = np.linspace(0.0, 2.0 * np.pi, 33)[:-1]
        size = radius * self.weight / self.times
        self.line(at_px + size * np.column_stack([np.cos(turn), np.sin(turn)]), colour, True)

    def cross(self, at_px: Array, radius: float, colour: Colour) -> None:
        """At a point (2,), as ``ring``."""
        size = radius * self.weight / self.times
        for way in ((1.0, 0.0), (0.0, 1.0)):
            ends = np.multiply.outer([-size, size], way)
            self.line(at_px + ends, colour, thick=2)

    def write(self, words: str, at_px: Sequence[float] | Array, colour: Colour) -> None:
        """Words from a point (2,) on, within the picture, over a dark edge, beside other words."""
        height, width = self.pixels.shape[:2]
        size, thick = _LETTERS * self.weight, self._thick
        (wide, high), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, size, thick)
        if wide > width - 4:
            size *= (width - 4) / wide
            wide = width - 4
        x = int(np.clip(at_px[0] * self.times, 2, max(width - wide - 2, 2)))
        wanted = np.clip(at_px[1] * self.times, high + 2, height - 4)
        step = high + 4
        away = [0, *(sign * n * step for n in range(1, 8) for sign in (1, -1))]
        rows = [int(wanted + by) for by in away if high + 2 <= wanted + by <= height - 4]
        free = (y for y in rows if not self._covers(x, y - high, x + wide, y + 2))
        y = next(free, int(wanted))
        self.written.append((x, y - high, x + wide, y + 2))
        # A thick text is wider, so that the edge is the same text beside itself.
        edge = [((20, 20, 20), dx, dy) for dx in (-thick, 0, thick) for dy in (-thick, 0, thick)]
        for shade, dx, dy in [*edge, (colour, 0, 0)]:
            cv2.putText(
                self.pixels, words, (x + dx, y + dy), cv2.FONT_HERSHEY_SIMPLEX, size, shade, thick,
                cv2.LINE_AA,
            )  # fmt: skip

    def _covers(self, left: int, top: int, right: int, bottom: int) -> bool:
        return any(
            left < x_to and right > x and top < y_to and bottom > y
            for x, y, x_to, y_to in self.written
        )
