"""Which of the parts that were found is measured."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from servosight.tracking.core import TrackOptions, TrackRefused
from servosight.tracking.methods._composite import instead, more_telling
from servosight.tracking.methods._composite import surer as surer_of
from servosight.tracking.methods._footage import Footage

PICTURE = partial(np.zeros, (4, 4, 3), np.uint8)
AS_FILMED = cast(Any, SimpleNamespace(coloured=False))
SHARES = (0.5, 0.45, 0.2)  # of the change that the parts explain about a rough pivot


@pytest.mark.parametrize(
    ("options", "there"),
    [
        (TrackOptions(), True),
        (TrackOptions(pick=2), True),
        (TrackOptions(pick=3), True),
        (TrackOptions(pick=4), False),
        (TrackOptions(tip=(20.0, 30.0)), True),
    ],
)
def test_a_part_that_explains_enough_is_measured(
    monkeypatch: pytest.MonkeyPatch, options: TrackOptions, there: bool
) -> None:
    unused = cast(Any, None)
    footage = Footage(unused, options, unused, unused, unused, (), None)
    parts = [cast(Any, SimpleNamespace(explained_there=share)) for share in SHARES]
    monkeypatch.setattr(Footage, "nothing", lambda *_: TrackRefused("not there", PICTURE))
    with nullcontext() if there else pytest.raises(TrackRefused, match="not there"):
        footage.check(parts)


@pytest.mark.parametrize(
    ("explained", "again", "raised"),
    [
        ([], None, "first"),
        ([0.39], None, "first"),
        ([0.41], TrackRefused("second", PICTURE), "first"),
        ([0.7], TrackRefused("second", PICTURE, measured=True), "second"),
        ([0.7, 0.6], TrackRefused("second", PICTURE, measured=True), "second"),
    ],
)
def test_the_more_telling_refusal_is_raised(
    monkeypatch: pytest.MonkeyPatch,
    explained: list[float],
    again: TrackRefused | None,
    raised: str,
) -> None:
    """Of parts that the frames refuse; others than the first one are measured where they may
    explain enough, which is 40 % about a rough pivot."""
    unused = cast(Any, None)
    footage = Footage(unused, TrackOptions(), unused, AS_FILMED, unused, (), None)

    def measured(self: Footage, part: Any, progress: Any) -> Any:
        assert again is not None
        raise again

    monkeypatch.setattr(Footage, "measured", measured)
    monkeypatch.setattr(Footage, "candidate", lambda *_: None)
    others = [cast(Any, SimpleNamespace(explained_there=s)) for s in (0.9, *explained)]
    with pytest.raises(TrackRefused, match=raised):
        instead(footage, others, 1, TrackRefused("first", PICTURE), None)


def test_a_part_that_explains_enough_is_tried_before_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two pieces of a screen, of half of which a turn explains the change, and then a horn."""
    unused = cast(Any, None)
    footage = Footage(unused, TrackOptions(), unused, AS_FILMED, unused, (), None)
    tried: list[float] = []

    def measured(self: Footage, part: Any, progress: Any) -> Any:
        tried.append(part.explained_there)
        raise TrackRefused("", PICTURE)

    monkeypatch.setattr(Footage, "measured", measured)
    monkeypatch.setattr(Footage, "candidate", lambda *_: None)
    others = [cast(Any, SimpleNamespace(explained_there=s)) for s in (0.9, 0.5, 0.51, 0.85)]
    with pytest.raises(TrackRefused):
        instead(footage, others, 1, TrackRefused("", PICTURE), None)
    assert tried == [0.85, 0.5]


def test_of_one_part_the_refusal_with_the_smaller_sigma_counts() -> None:
    """A rough track of 0.3 deg, another one of 0.4 deg, and none."""
    surer, rough = (
        TrackRefused("", PICTURE, measured=True, uncertain=True, rough=uncertain_by(sigma_deg))
        for sigma_deg in (0.3, 0.4)
    )
    none = TrackRefused("", PICTURE)
    for first, second in ((surer, rough), (rough, surer), (surer, none), (none, surer)):
        assert surer_of(first, second) is surer
    assert surer_of(none, TrackRefused("", PICTURE)) is none


def test_colour_that_is_surer_counts_if_the_same_part_turns_there() -> None:
    """A sigma of 0.4 deg in grey, of 0.3 deg in colour: none counts where different parts turn at
    one place, that in grey where they turn beside each other, 100 px apart and 40 px long."""
    grey, colour, other, second = (
        TrackRefused("", PICTURE, measured=True, uncertain=True, rough=rough)
        for rough in (
            uncertain_by(0.4), uncertain_by(0.3), uncertain_by(0.3, -1.0),
            uncertain_by(0.3, -1.0, 100.0),
        )
    )  # fmt: skip
    assert more_telling(grey, second) is grey
    assert more_telling(grey, colour) is colour
    assert more_telling(grey, other).rough is None
    assert more_telling(grey, TrackRefused("", PICTURE, measured=True)) is grey


def uncertain_by(sigma_deg: float, turned: float = 1.0, x_px: float = 0.0) -> Any:
    """What is asked of a track, of a part of 40 px about a pivot at ``x_px``."""
    return SimpleNamespace(
        found=np.ones(9, bool), sigma_deg=np.full(9, sigma_deg), angle_deg=turned * np.arange(9.0),
        pivot_px=(x_px, 0.0), outline_px=np.array([[x_px, 0.0], [x_px, 40.0]]),
    )  # fmt: skip
