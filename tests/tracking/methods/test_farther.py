"""Which of two refusals of one video is said."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from servosight.tracking.core import TrackRefused
from servosight.tracking.methods._refine import _farther

PICTURE = partial(np.zeros, (4, 4, 3), np.uint8)


@pytest.mark.parametrize(
    ("found", "again_found", "pointed", "said"),
    [
        (False, False, False, "nothing moves"),
        (False, False, True, "nothing there"),  # the first one speaks of the whole picture
        (True, False, True, "nothing moves"),
        (True, True, False, "nothing there"),
    ],
)
def test_the_refusal_that_helps_is_said(
    found: bool, again_found: bool, pointed: bool, said: str
) -> None:
    first = TrackRefused("nothing moves", PICTURE, found=found)
    again = TrackRefused("nothing there", PICTURE, found=again_found)
    assert str(_farther(first, again, pointed)) == said
