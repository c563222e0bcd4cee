"""What enters the pictures beside a part is left out; an uncertain part is not to be of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from servosight.tracking.composite import FoundPart, StabilisedSample
from servosight.tracking.methods._entered import clear_of, left_out_of

RNG = np.random.default_rng(1)
STILL = 100.0 + RNG.normal(0.0, 1.0, (20, 60, 80)).astype(np.float32)
ENTERED = STILL.copy()
ENTERED[5:8, :, :15] = 180.0
CONTENT = np.ones((60, 80), bool)


def found(inside: bool, **given: Any) -> FoundPart:
    """What is asked of a part that was found."""
    return cast(FoundPart, SimpleNamespace(inside=inside, beside=None, **given))


def stabilised(pictures: Any) -> StabilisedSample:
    return cast(StabilisedSample, SimpleNamespace(pictures=pictures, content=CONTENT))


def test_a_part_found_with_what_enters_is_not_clear_of_it() -> None:
    """Someone at the left in three of twenty pictures."""
    assert clear_of(found(inside=False), stabilised(STILL))
    assert clear_of(found(inside=True), stabilised(ENTERED))
    assert not clear_of(found(inside=False), stabilised(ENTERED))


def test_what_enters_is_left_out_where_the_part_was_found_without_it() -> None:
    gone = left_out_of(found(inside=True), CONTENT, ENTERED)
    assert gone[5:8, :, :15].all()
    assert not gone[:5].any()
    assert not left_out_of(found(inside=False), CONTENT, ENTERED).any()
