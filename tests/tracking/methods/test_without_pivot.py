"""A pivot that is pointed at is never worse than nothing given."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.tracking.composite import TRUST
from servosight.tracking.core import Track, TrackOptions, TrackRefused
from servosight.tracking.methods import _composite

CORNERS = np.array([[0.0, -10.0], [20.0, -10.0], [20.0, 10.0]])
ROUGH = replace(
    drawn_part(
        (61.0, 40.0), np.array([[0.0, -10.0], [20.0, -10.0], [20.0, 10.0]]), np.linspace(0, 40, 9)
    ),
    sigma_deg=np.full(9, 2.0 * TRUST.largest_sigma_deg),
)
SURE = replace(ROUGH, sigma_deg=ROUGH.sigma_deg / 3.0)
ROUGHER = replace(ROUGH, sigma_deg=2.0 * ROUGH.sigma_deg)
ELSEWHERE = replace(SURE, pivot_px=(90.0, 40.0))
TILTED = replace(ROUGH, shared_deg=0.99 * ROUGH.sigma_deg[:, None])
REFUSED = TrackRefused("fin.mp4: nothing turns.", lambda: np.zeros((4, 4, 3), np.uint8))


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
