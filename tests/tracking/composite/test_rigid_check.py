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
    assert pattern_of(angle, wrong + 0.1 * noise) == pytest.approx(np.std(wrong), rel=0.1)
    assert pattern_of(angle, noise) == 0.0
    assert pattern_of(angle[:9], wrong[:9]) == 0.0
