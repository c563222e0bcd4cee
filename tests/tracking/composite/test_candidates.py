"""Which of the parts that were found is measured."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from servosight.tracking.core import TrackOptions
from servosight.tracking.methods._composite import Footage

SHARES = (0.5, 0.45, 0.2)  # of the change that the parts explain about a rough pivot


@pytest.mark.parametrize(
    ("options", "expected"),
    [(TrackOptions(), 0.5), (TrackOptions(pick=2), 0.45), (TrackOptions(tip=(20.0, 30.0)), 0.5)],
)
def test_the_part_that_explains_most_is_measured_or_the_one_picked(
    options: TrackOptions, expected: float
) -> None:
    unused = cast(Any, None)
    footage = Footage(unused, options, unused, unused, unused, None)
    parts = [cast(Any, SimpleNamespace(explained=share)) for share in SHARES]
    assert footage.chosen(parts).explained == expected
