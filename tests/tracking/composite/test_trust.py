"""What a part must reach to be returned, each limit by itself."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.composite import TRUST, PoseFit, distrust
from servosight.tracking.composite._trust import worst_third


def fit(angle_rad: float, explained: float) -> PoseFit:
    none, square = np.zeros(2), np.zeros((3, 3))
    return PoseFit(angle_rad, none, square, 1.0, explained, 1.0, 0.0, 0.0, 0.1, 0.0, 0.0)


FITS = [fit(0.01 * n, 0.9) for n in range(30)]
SIGMA_DEG = np.full(30, TRUST.largest_sigma_deg)


def test_the_worst_third_of_the_angles_counts() -> None:
    """One end of the range of angles is explained badly; frames without the part do not count."""
    uneven = [None, *(fit(0.01 * n, 0.5 if n > 18 else 0.95) for n in range(30))]
    assert worst_third(uneven) == 0.5
    assert worst_third(FITS) == 0.9


def test_each_limit_refuses_by_itself() -> None:
    apart = TRUST.largest_apart_found_deg
    assert distrust(apart, SIGMA_DEG, FITS, pointed=False) is None
    cases = [
        (1.02 * apart, SIGMA_DEG, FITS, "without a pivot"),
        (0.0, 1.02 * SIGMA_DEG, FITS, "a sigma of"),
        (0.0, SIGMA_DEG, [fit(0.01 * n, 0.98 * TRUST.least_explained) for n in range(9)], "covers"),
    ]
    for apart_deg, sigma_deg, fits, word in cases:
        why = distrust(apart_deg, sigma_deg, fits, pointed=False)
        assert why is not None
        assert word in why
        assert "expected" in why


def test_of_a_wide_swing_a_share_counts() -> None:
    """An arm that swings through 249 deg may have a sigma of 0.62 deg: the range less its widest
    gap, a degree here."""
    wide = [fit(np.deg2rad(n), 0.9) for n in range(251)]
    assert distrust(0.0, 2.4 * SIGMA_DEG, wide, pointed=False) is None
    why = distrust(0.0, 2.5 * SIGMA_DEG, wide, pointed=False)
    assert why is not None
    assert "expected 0.623 deg at most" in why
    for pointed, most_deg in ((True, 1.245), (False, 0.83)):
        assert distrust(most_deg - 0.01, SIGMA_DEG, wide, pointed) is None
        why = distrust(most_deg + 0.01, SIGMA_DEG, wide, pointed)
        assert why is not None
        assert "without a pivot" in why


def test_a_wheel_that_turns_on_and_on_has_no_more_than_a_turn_of_angles() -> None:
    """Ten turns in steps of 18 deg allow no sigma of 9 deg, nor angles that are 18 deg apart."""
    wheel = [fit(np.deg2rad(18.0 * n), 0.9) for n in range(201)]
    assert distrust(0.0, np.full(201, 0.9), wheel, pointed=False) is None
    assert distrust(0.0, np.full(201, 0.91), wheel, pointed=False) is not None
    assert distrust(1.81, np.full(201, 0.1), wheel, pointed=False) is not None


@pytest.mark.parametrize(("apart_share", "refused"), [(0.9, False), (1.1, True)])
def test_a_part_pointed_at_may_be_measured_roughly(apart_share: float, refused: bool) -> None:
    apart_deg = apart_share * TRUST.largest_apart_deg
    poor = [fit(0.04 * n, 0.2) for n in range(9)]
    assert (distrust(apart_deg, 4.0 * SIGMA_DEG, poor, pointed=True) is not None) == refused


def test_of_a_small_motion_little_may_change_without_the_pivot() -> None:
    """Of 2 deg, the range less its widest gap of 0.2 deg, 0.08 deg: more is a part that slides."""
    small = [fit(np.deg2rad(0.2 * n), 0.9) for n in range(12)]
    for pointed in (True, False):
        assert distrust(0.075, 0.5 * SIGMA_DEG, small, pointed) is None
        why = distrust(0.085, 0.5 * SIGMA_DEG, small, pointed)
        assert why is not None
        assert "without a pivot" in why


def test_a_part_with_its_shadow_is_refused_unless_it_is_pointed_at() -> None:
    """Rendered flap and rudder, about points 27 to 62 px from their pivots: 18 and 44 deg."""
    for moved_deg, apart_deg in ((18.2, 0.171), (16.0, 0.165), (43.7, 0.152)):
        seen = [fit(np.deg2rad(n), 0.9) for n in np.linspace(0.0, moved_deg, 60)]
        why = distrust(apart_deg, SIGMA_DEG, seen, pointed=False)
        assert why is not None
        assert "without its shadow" in why
        assert distrust(apart_deg, SIGMA_DEG, seen, pointed=True) is None
