"""Pictures that are woven of two fields, told by their lines."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Image
from servosight.tracking.video._fields import FieldOrder, most_different, woven_fields


def bar(place_px: float, rng: np.random.Generator, lines: bool = False) -> Image:
    """A bright bar at a place in a row, in noise, before a wall of fine ``lines``."""
    x = np.arange(160.0)
    row = 60.0 + 120.0 * np.clip(6.0 - np.abs(x - place_px), 0.0, 1.0)
    image = np.tile(row, (120, 1)) + rng.normal(0.0, 2.0, (120, 160))
    if lines:
        image[::2] += 40.0
    return np.clip(image, 0.0, 255.0).astype(np.uint8)


def weave(first: Image, second: Image, order: FieldOrder) -> Image:
    woven = first.copy()
    odd = order is FieldOrder.TOP
    woven[int(odd) :: 2] = second[int(odd) :: 2]
    return woven


@pytest.mark.parametrize("order", list(FieldOrder))
def test_the_order_of_woven_fields(order: FieldOrder) -> None:
    """Truth: a bar that moves by 4 px from field to field."""
    rng = np.random.default_rng(0)
    run = [bar(30.0 + 4.0 * n, rng) for n in range(20)]
    woven = [weave(*pair, order) for pair in zip(run[::2], run[1::2], strict=True)]
    pair = most_different(woven)
    assert pair is not None
    assert woven_fields([pair]) is order


@pytest.mark.parametrize("lines", [False, True])
def test_whole_pictures_are_not_woven(lines: bool) -> None:
    """Nor are those of a wall of lines as fine as the picture's own."""
    rng = np.random.default_rng(1)
    pair = most_different([bar(30.0 + 8.0 * n, rng, lines) for n in range(10)])
    assert pair is not None
    assert woven_fields([pair]) is None


def test_nothing_is_told_where_nothing_moves() -> None:
    still = bar(80.0, np.random.default_rng(2))
    assert woven_fields([(still, still)]) is None
    assert most_different([still]) is None
