"""What a pivot that is off does to the angles, as against chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.tracking.composite._rigid_check import (
    pattern_of,
    proportional_rad,
    sides_apart_rad,
)
from servosight.tracking.composite.model import PoseFit


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


def test_a_share_of_the_angle_shows_in_frames_that_tell_little_each() -> None:
    """Truth: angles of which a third is missing without the pivot, over 3 deg, where each frame
    shows its direction within 0.6 deg. A share of 4 %, and chance, are none."""
    rng = np.random.default_rng(5)
    angle = np.deg2rad(rng.uniform(0.0, 3.0, 90))
    sigma = np.full(90, np.deg2rad(0.6))
    noise = sigma * rng.standard_normal(90)
    missing = -angle / 3.0
    expected = pytest.approx(np.std(missing), rel=0.3)
    assert pattern_of(angle, missing + noise, sigma) == 0.0
    assert proportional_rad(angle, missing + noise, sigma) == expected
    assert proportional_rad(angle, 0.04 * angle + 0.1 * noise, 0.1 * sigma) == 0.0
    assert proportional_rad(angle, noise, sigma) == 0.0
    assert proportional_rad(angle[:9], missing[:9], sigma[:9]) == 0.0


def test_halves_are_apart_by_what_varies_and_a_hand_counts_as_five_times_the_usual() -> None:
    """Truth: differences of 0.3 rad, which all share, and of 0.02 rad to either side, which not."""
    usual = PoseFit(0.0, np.zeros(2), np.eye(3), 1.0, 1.0, 1.0, 0.3, 0.01, 0.1, 0.0, 0.0)
    fits = [replace(usual, sides_rad=0.3 + 0.02 * sign) for sign in (-1, 1) * 20]
    assert sides_apart_rad([*fits, None]) == pytest.approx(0.02)
    hidden = [replace(usual, sides_rad=9.0)]
    expected = np.sqrt((40 * 0.02**2 + (5 * 0.02) ** 2) / 41)
    assert sides_apart_rad([*fits[:20], usual, *fits[20:-1], *hidden]) < 1.2 * expected
