"""A sample of a video's frames, small and smooth, kept while the video passes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.video import Frame

_COUNT = 48
_LONG_SIDE_PX = 480
_SMOOTH_PX = 1.0


@dataclass
class FrameSample:
    """At most 96 and, in a long video, at least 48 of its frames, evenly spread, the first one
    first; or those whose numbers are in ``only``.

    ``prepare`` is applied to a frame's picture first. The longer side of a kept picture is at most
    480 px, ``scale`` its size over that of the video's. ``roll_rad`` are the camera's own turns,
    which were removed from the pictures.
    """

    prepare: Callable[[Image], Image]
    index: list[int] = field(default_factory=list)
    pictures: list[Single] = field(default_factory=list)
    roll_rad: list[float] = field(default_factory=list)
    scale: float = 1.0
    stride: int = 1
    only: frozenset[int] | None = None

    @classmethod
    def of_video(cls, prepare: Callable[[Image], Image], count: int) -> FrameSample:
        """Of a video of ``count`` frames, if that is right: no more of them are prepared than are
        kept at the end."""
        stride = 1
        while -(-count // stride) >= 2 * _COUNT:
            stride *= 2
        return cls(prepare, stride=stride)

    def watch(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """The same frames in the same order; some of them are kept."""
        for frame in frames:
            self.add(frame)
            yield frame

    def add(self, frame: Frame) -> None:
        """The next frame, which is kept or not."""
        if not self._keeps(frame.index):
            return
        self.scale = min(1.0, _LONG_SIDE_PX / max(frame.image.shape))
        self.index.append(frame.index)
        self.pictures.append(small(self.prepare(frame.image), self.scale))
        self.roll_rad.append(frame.roll_rad)
        if self.only is None and len(self.index) >= 2 * _COUNT:
            self.index, self.pictures = self.index[::2], self.pictures[::2]
            self.roll_rad = self.roll_rad[::2]
            self.stride *= 2

    def _keeps(self, index: int) -> bool:
        return index % self.stride == 0 if self.only is None else index in self.only

    def chosen(self, kept: Mask) -> tuple[Array, list[Single], Array]:
        """Numbers, pictures and the camera's turns of the sampled frames that ``kept`` (frames,)
        marks, at most 48."""
        rows = [row for row, index in enumerate(self.index) if kept[index]]
        rows = rows[:: max(1, -(-len(rows) // _COUNT))]
        numbers = np.array([self.index[row] for row in rows], int)
        rolls = np.array([self.roll_rad[row] for row in rows])
        return numbers, [self.pictures[row] for row in rows], rolls


def at_scale(points: Array, scale: float) -> Array:
    """Points of a picture (..., 2) in one ``scale`` times as large: pixels' middles are whole."""
    return np.asarray((points + 0.5) * scale - 0.5)


def small(image: Image | Single, scale: float) -> Single:
    """A picture ``scale`` times as large, smoothed by a Gaussian of 1 px."""
    resized: Any = image.astype(np.float32)
    if scale < 1.0:
        resized = cv2.resize(resized, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(resized, (0, 0), _SMOOTH_PX), np.float32)
