"""A piece of a video's pictures."""

from __future__ import annotations

import numpy as np

from servosight.tracking.video import Frame, Window, windowed


def test_a_window_stays_inside_and_keeps_its_size() -> None:
    """Truth by hand: a square of 60 px about places near each corner of 100 x 80 px."""
    shape = (80, 100)
    assert Window.around((5.0, 5.0), 60, shape) == Window(0, 0, 60, 60)
    assert Window.around((95.0, 75.0), 60, shape) == Window(40, 20, 60, 60)
    assert Window.around((50.0, 40.0), 90, shape) == Window(5, 0, 90, 80)


def test_frames_are_cut_with_their_colour() -> None:
    image = np.arange(48, dtype=np.uint8).reshape(6, 8)
    frame = Frame(3, 0.1, image, colour=np.stack([image, image + 100]))
    (seen,) = windowed([frame], Window(2, 1, 4, 3))
    assert (seen.index, seen.time_s) == (3, 0.1)
    np.testing.assert_array_equal(seen.image, image[1:4, 2:6])
    assert seen.colour is not None
    np.testing.assert_array_equal(seen.colour[1], image[1:4, 2:6] + 100)
    assert next(windowed([frame], None)) is frame
