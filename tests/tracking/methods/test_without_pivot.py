"""A pivot that is pointed at is never worse than nothing given."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.tracking.composite import TRUST
from servosight.tracking.core import PICTURE, Track, TrackOptions, TrackRefused
from servosight.tracking.methods import _composite

ROUGH = Track(
    video=Path("fin.mp4"),
    method="refine",
    time_s=np.arange(9) / 30.0,
    angle_deg=np.linspace(0.0, 40.0, 9),
    sigma_deg=np.full(9, 2.0 * TRUST.largest_sigma_deg),
    flags=np.zeros(9, np.uint8),
    pivot_px=(61.0, 40.0),
    template_px=(10, 10, 20, 20),
    outline_px=np.array([[10.0, 10.0], [30.0, 10.0], [30.0, 30.0]]),
    plane=PICTURE,
    notes=(),
)
SURE = replace(ROUGH, sigma_deg=ROUGH.sigma_deg / 3.0)
ROUGHER = replace(ROUGH, sigma_deg=2.0 * ROUGH.sigma_deg)
ELSEWHERE = replace(SURE, pivot_px=(90.0, 40.0))
TILTED = replace(ROUGH, shared_deg=0.99 * ROUGH.sigma_deg[:, None])
REFUSED = TrackRefused("fin.mp4: nothing turns.", np.zeros((4, 4, 3), np.uint8))


def returned(
    monkeypatch: pytest.MonkeyPatch, given: Track | TrackRefused, without: Track | TrackRefused,
    **hints: Any,
) -> Track:  # fmt: skip
    """What is returned where the first is found as the hints say, and the second with none."""

    def as_given(_: object, options: TrackOptions, __: object) -> Track:
        found = given if options.pointed else without
        if isinstance(found, TrackRefused):
            raise found
        return found

    monkeypatch.setattr(_composite, "_as_given", as_given)
    film: Any = SimpleNamespace(images=[np.zeros((120, 200), np.uint8)])
    return _composite.composite(film, TrackOptions(**(hints or {"pivot": (52.0, 40.0)})))


def test_what_is_found_without_the_pivot_is_taken_where_it_is_surer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its pivot is 9 px from the click, of 12 that a click may be off in pictures of 200 px."""
    assert returned(monkeypatch, REFUSED, SURE) is SURE
    assert returned(monkeypatch, ROUGH, SURE) is SURE
    assert returned(monkeypatch, ROUGH, ROUGHER) is ROUGH
    assert returned(monkeypatch, ROUGH, REFUSED) is ROUGH


def test_what_is_found_elsewhere_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    assert returned(monkeypatch, ROUGH, ELSEWHERE) is ROUGH
    with pytest.raises(TrackRefused):
        returned(monkeypatch, REFUSED, ELSEWHERE)


def test_a_sure_angle_and_other_hints_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sure is also what a tilt alone makes uncertain, since no other pivot removes that."""
    surer = replace(SURE, sigma_deg=SURE.sigma_deg / 9.0)
    assert returned(monkeypatch, SURE, surer) is SURE
    assert returned(monkeypatch, TILTED, surer) is TILTED
    assert returned(monkeypatch, ROUGH, SURE, tip=(20.0, 20.0)) is ROUGH
