"""Each piece of what changes by itself, as where a text is laid over the pictures."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Single
from servosight.tracking.composite.parts import Change, Reference, pieces_of

CHANGE = Change.of(np.full((5, 60, 80), 100.0, np.float32))


def changed(*boxes: tuple[slice, slice]) -> Reference:
    """A picture that differs from the usual one in these places."""
    cover = np.zeros(CHANGE.usual.shape, np.float32)
    for box in boxes:
        cover[box] = 1.0
    return Reference(CHANGE.usual + 50.0 * cover, cover, 3)


def test_pieces_are_those_that_are_connected_and_large() -> None:
    part, text = (slice(10, 30), slice(10, 40)), (slice(40, 50), slice(20, 60))
    speck = (slice(5, 7), slice(70, 72))
    whole = changed(part, text, speck)
    pieces = pieces_of([whole], CHANGE)
    covers: list[Single] = [changed(box).cover for box in (part, text)]
    np.testing.assert_array_equal([piece.cover for piece in pieces], covers)
    assert all(piece.picture is whole.picture and piece.number == 3 for piece in pieces)


@pytest.mark.parametrize("boxes", [(), [(slice(10, 30), slice(10, 40))]])
def test_a_change_of_one_piece_or_none_stays_as_it_is(boxes: list[tuple[slice, slice]]) -> None:
    whole = changed(*boxes)
    (only,) = pieces_of([whole], CHANGE)
    np.testing.assert_array_equal(only.cover, whole.cover)
