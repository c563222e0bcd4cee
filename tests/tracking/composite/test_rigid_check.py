"""What a pivot that is off does to the angles, as against chance."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.composite._rigid_check import pattern_of


def test_a_scale_of_the_angle_shows_and_chance_does_not() -> None:
    """Truth: angles 10 % too small over 0.4 rad, beside noise of 0.01 rad."""
    rng = np.random.default_rng(2)
    angle = rng.uniform(-0.2, 0.2, 60)
    noise = 0.01 * rng.standard_normal(60)
    wrong = 0.1 * angle
    sure = np.full(60, 0.003)
    assert pattern_of(angle, wrong + 0.1 * noise, sure) == pytest.approx(np.std(wrong), rel=0.1)
    assert pattern_of(angle, noise, sure) == 0.0
    assert pattern_of(angle[:9], wrong[:9], sure[:9]) == 0.0
    # A part that does not show its own direction says nothing.
    assert pattern_of(angle, wrong + 0.1 * noise, 4.0 * sure) == 0.0
