"""A piece of a video's pictures, for a part that is small in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Image
from servosight.tracking.video._video import Frame


@dataclass(frozen=True)
class Window:
    """A piece of pictures, by its upper left pixel and its size [px]."""

    x: int
    y: int
    width: int
    height: int

    @classmethod
    def around(cls, place_px: tuple[float, float], side_px: int, shape: tuple[int, ...]) -> Window:
        """A square about a place, moved into pictures (height, width) and cut off by them.

        >>> Window.around((20.0, 100.0), 60, (240, 320))
        Window(x=0, y=70, width=60, height=60)
        """
        width, height = min(side_px, shape[1]), min(side_px, shape[0])
        x, y = (round(at - 0.5 * side_px) for at in place_px)
        x, y = min(max(x, 0), shape[1] - width), min(max(y, 0), shape[0] - height)
        return cls(x, y, width, height)

    def of(self, image: Image) -> Image:
        """The piece of a picture (..., height, width), a view of it."""
        return image[..., self.y : self.y + self.height, self.x : self.x + self.width]


def windowed(frames: Iterable[Frame], window: Window | None) -> Iterator[Frame]:
    """The frames' piece in a window; the frames themselves if it is None."""
    for frame in frames:
        if window is None:
            yield frame
            continue
        colour = None if frame.colour is None else window.of(frame.colour)
        image = np.ascontiguousarray(window.of(frame.image))
        yield replace(frame, image=image, colour=colour)
