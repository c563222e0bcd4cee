"""A track whose sigma is large by several small errors together says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.tracking.core import Shutters, Track
from servosight.tracking.methods._total_sigma import with_total_sigma

CORNERS = np.array([[0.0, -3.0], [40.0, -3.0], [40.0, 3.0], [0.0, 3.0]])
ANGLE_DEG = 20.0 * np.sin(np.arange(60) / 6.0)
TRACK = drawn_part((60.0, 50.0), CORNERS, ANGLE_DEG)
LATE = Shutters(np.array([0.004]), 0.0, exposure_doubt_s=0.0015)


def doubted(sigma_deg: float, shutters: Shutters) -> tuple[Track, bool]:
    own = np.full(ANGLE_DEG.size, sigma_deg)
    track = with_total_sigma(replace(TRACK, sigma_deg=own, shutters=shutters))
    return track, any("all angles are uncertain" in note for note in track.notes)


@pytest.mark.parametrize(
    ("sigma_deg", "exposure_doubt_s", "said"),
    [(0.2, 0.0, False), (0.05, 0.0015, False), (0.2, 0.0015, True), (0.3, 0.0, True)],
)
def test_noise_and_times_that_are_each_small_are_said_together(
    sigma_deg: float, exposure_doubt_s: float, said: bool
) -> None:
    """Of 40 deg: more than 0.25 deg in half of the frames; times make 0.18 deg in the median."""
    track, told = doubted(sigma_deg, replace(LATE, exposure_doubt_s=exposure_doubt_s))
    assert (float(np.median(track.sigma_deg)) > 0.25) == said
    assert told == said


def test_it_is_said_however_far_the_part_turns() -> None:
    """0.4 deg of 240 deg: little of the motion, and more than half a degree in a fifth of the
    frames."""
    wide = replace(TRACK, angle_deg=6.0 * TRACK.angle_deg, sigma_deg=np.full(60, 0.4))
    (note,) = with_total_sigma(replace(wide, shutters=None)).notes
    assert "uncertain by 0.4 deg" in note
