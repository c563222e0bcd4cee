"""A fan beside the part: what turns on and on is left out where another part turns back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.models.core import FrameProgress
from servosight.tracking.core import Track, TrackOptions, TrackRefused
from servosight.tracking.methods import beside_what_turns_evenly
from servosight.tracking.video import Film

CORNERS = np.array([[0.0, -10.0], [20.0, -10.0], [20.0, 10.0]])
FRAMES = 200
FAN = drawn_part((61.0, 40.0), CORNERS, np.linspace(0.0, 2000.0, FRAMES))
SERVO = drawn_part((161.0, 40.0), CORNERS, 30.0 * np.sin(np.linspace(0.0, 20.0, FRAMES)))
WHEEL = drawn_part((161.0, 40.0), CORNERS, 900.0 * np.linspace(0.0, 1.0, FRAMES) ** 2)
OTHER_FAN = drawn_part((161.0, 40.0), CORNERS, np.linspace(0.0, 900.0, FRAMES))


@dataclass
class Found:
    """A method that finds ``first``, and ``second`` beside it; None: nothing."""

    first: Track
    second: Track | None = None
    asked: list[TrackOptions] = field(default_factory=list)

    def __call__(
        self, film: Film, options: TrackOptions, progress: FrameProgress | None = None
    ) -> Track:
        self.asked.append(options)
        found = self.first if options.beside is None else self.second
        if found is None:
            raise TrackRefused("nothing turns.", lambda: np.zeros((4, 4, 3), np.uint8))
        return found


def tracked(method: Found, **hints: Any) -> Track:
    film: Any = None
    return beside_what_turns_evenly(method, film, TrackOptions(**hints))


def test_the_part_beside_a_fan_is_measured_and_the_fan_named() -> None:
    method = Found(FAN, SERVO)
    found = tracked(method)
    assert found.pivot_px == SERVO.pivot_px
    assert np.array_equal(found.angle_deg, SERVO.angle_deg)
    assert "the part about 61,40 px turns on and on at an even speed" in found.notes[0]
    assert "--pivot 61,40 takes it" in found.notes[0]
    assert method.asked[1].beside is FAN


@pytest.mark.parametrize("second", [None, OTHER_FAN])
def test_a_fan_alone_is_measured(second: Track | None) -> None:
    assert tracked(Found(FAN, second)) is FAN


@pytest.mark.parametrize("first", [SERVO, WHEEL])
def test_what_turns_back_or_unevenly_is_measured_at_once(first: Track) -> None:
    method = Found(first, FAN)
    assert tracked(method) is first
    assert len(method.asked) == 1


@pytest.mark.parametrize("hints", [{"pivot": (61.0, 40.0)}, {"pick": 2}, {"beside": SERVO}])
def test_a_fan_that_is_asked_for_is_measured(hints: dict[str, Any]) -> None:
    assert tracked(Found(FAN, FAN), **hints) is FAN
