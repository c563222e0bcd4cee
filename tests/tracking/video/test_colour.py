"""Frames with their differences of colour, beside the grey that is read without them."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.tracking.core import NEUTRAL, Channel
from servosight.tracking.video import Frame, frames

SIZE = (64, 48)  # width, height
COUNT = 50
CB, CR = 90, 170
LEFT = 24  # columns that have a colour
EDGE = 4


def written(path: Path, pixels: str, turned_deg: int = 0) -> Path:
    """A film of grey noise, at its left with a colour, without loss."""
    rng = np.random.default_rng(3)
    width, height = SIZE
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(30), options={"qp": "0"})
        stream.width, stream.height, stream.pix_fmt = width, height, pixels
        if turned_deg:
            stream.set_display_rotation(turned_deg)
        for _ in range(COUNT):
            planes = np.full((3, height, width), NEUTRAL, np.uint8)
            planes[0] = rng.integers(40, 200, (height, width))
            planes[1, :, :LEFT], planes[2, :, :LEFT] = CB, CR
            frame = av.VideoFrame.from_ndarray(planes, format="yuv444p")
            container.mux(stream.encode(frame.reformat(format=pixels)))
        container.mux(stream.encode())
    return path


def both(path: Path) -> list[tuple[Frame, Frame]]:
    return list(zip(frames(path), frames(path, coloured=True), strict=True))


def colour_of(frame: Frame) -> NDArray[np.uint8]:
    assert frame.colour is not None
    return frame.colour


@pytest.mark.parametrize("pixels", ["yuv420p", "yuv422p", "yuv444p", "gray"])
def test_the_grey_is_the_same_with_and_without_colour(tmp_path: Path, pixels: str) -> None:
    pairs = both(written(tmp_path / "film.mp4", pixels))
    assert len(pairs) == COUNT
    for plain, coloured in pairs:
        assert plain.colour is None
        assert np.array_equal(plain.image, coloured.image)
        assert colour_of(coloured).shape == (2, *coloured.image.shape)


@pytest.mark.parametrize("pixels", ["yuv420p", "yuv444p"])
def test_differences_of_colour_are_those_of_the_file(tmp_path: Path, pixels: str) -> None:
    """Truth: what was written. The kernels that halve and double the size reach four pixels."""
    _, frame = both(written(tmp_path / "film.mp4", pixels))[-1]
    cb, cr = colour_of(frame).astype(int)
    assert np.abs(cb[:, : LEFT - EDGE] - CB).max() <= 1
    assert np.abs(cr[:, : LEFT - EDGE] - CR).max() <= 1
    assert np.abs(colour_of(frame)[:, :, LEFT + EDGE :] - NEUTRAL).max() <= 1


def test_a_grey_film_has_no_colour(tmp_path: Path) -> None:
    assert all(
        (colour_of(seen) == NEUTRAL).all() for _, seen in both(written(tmp_path / "g.mp4", "gray"))
    )


def test_colour_is_turned_as_the_grey_is(tmp_path: Path) -> None:
    """By a tag of 90 deg counter-clockwise, which brings the left to the bottom."""
    _, frame = both(written(tmp_path / "film.mp4", "yuv420p", turned_deg=90))[0]
    assert frame.tag_deg == 90
    assert frame.image.shape == (SIZE[0], SIZE[1])
    cb = colour_of(frame)[0].astype(int)
    assert np.abs(cb[-LEFT + EDGE :] - CB).max() <= 1
    assert np.abs(cb[: -LEFT - EDGE] - NEUTRAL).max() <= 1


def test_a_channel_of_colour_is_a_weighted_sum(tmp_path: Path) -> None:
    _, frame = both(written(tmp_path / "film.mp4", "yuv444p"))[0]
    mixed = Channel(cb=-0.6, cr=0.8).mixed(*colour_of(frame))
    expected = NEUTRAL - 0.6 * (CB - NEUTRAL) + 0.8 * (CR - NEUTRAL)
    assert np.abs(mixed[:, : LEFT - EDGE] - expected).max() <= 1.5
