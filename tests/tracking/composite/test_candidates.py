"""Which of the parts that were found is measured."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from servosight.tracking.core import TrackOptions, TrackRefused
from servosight.tracking.methods._footage import Footage

PICTURE = np.zeros((4, 4, 3), np.uint8)
SHARES = (0.5, 0.45, 0.2)  # of the change that the parts explain about a rough pivot


@pytest.mark.parametrize(
    ("options", "expected"),
    [(TrackOptions(), 0.5), (TrackOptions(pick=2), 0.45), (TrackOptions(tip=(20.0, 30.0)), 0.5)],
)
def test_the_part_that_explains_most_is_measured_or_the_one_picked(
    options: TrackOptions, expected: float
) -> None:
    unused = cast(Any, None)
    footage = Footage(unused, options, unused, unused, unused, (), None)
    parts = [cast(Any, SimpleNamespace(explained_there=share)) for share in SHARES]
    assert footage.chosen(parts).explained_there == expected


@pytest.mark.parametrize(
    ("explained", "again", "raised"),
    [
        ([], None, "first"),
        ([0.39], None, "first"),
        ([0.41], TrackRefused("second", PICTURE), "first"),
        ([0.7], TrackRefused("second", PICTURE, measured=True), "second"),
    ],
)
def test_the_more_telling_refusal_is_raised(
    monkeypatch: pytest.MonkeyPatch,
    explained: list[float],
    again: TrackRefused | None,
    raised: str,
) -> None:
    """Of two parts that the frames refuse; the second is measured where it may explain enough,
    which is 40 % about a rough pivot."""
    unused = cast(Any, None)
    footage = Footage(unused, TrackOptions(), unused, unused, unused, (), None)

    def measured(self: Footage, part: Any, progress: Any) -> Any:
        assert again is not None
        raise again

    monkeypatch.setattr(Footage, "measured", measured)
    others = [cast(Any, SimpleNamespace(explained_there=s)) for s in (0.9, *explained)]
    with pytest.raises(TrackRefused, match=raised):
        footage.instead(others, 1, TrackRefused("first", PICTURE), None)
