"""What a part must reach to be returned, each limit by itself."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.composite import TRUST, PoseFit, distrust
from servosight.tracking.composite._trust import jumps, worst_third


def fit(angle_rad: float, explained: float) -> PoseFit:
    return PoseFit(angle_rad, np.zeros(2), np.zeros((3, 3)), 1.0, explained, 1.0, 0.0, 0.0, 0.1)


FITS = [fit(0.01 * n, 0.9) for n in range(30)]
SIGMA_DEG = np.full(30, TRUST.largest_sigma_deg)


def test_the_worst_third_of_the_angles_counts() -> None:
    """One end of the range of angles is explained badly; frames without the part do not count."""
    uneven = [None, *(fit(0.01 * n, 0.5 if n > 18 else 0.95) for n in range(30))]
    assert worst_third(uneven) == 0.5
    assert worst_third(FITS) == 0.9


def test_each_limit_refuses_by_itself() -> None:
    apart = TRUST.largest_apart_deg
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
    """An arm that swings through 249 deg may have a sigma of 0.62 deg."""
    wide = [fit(np.deg2rad(249.0 / 29.0) * n, 0.9) for n in range(30)]
    assert distrust(0.0, 2.4 * SIGMA_DEG, wide, pointed=False) is None
    why = distrust(0.0, 2.5 * SIGMA_DEG, wide, pointed=False)
    assert why is not None
    assert "expected 0.623 deg at most" in why


@pytest.mark.parametrize(("apart_share", "refused"), [(0.9, False), (1.1, True)])
def test_a_part_pointed_at_may_be_measured_roughly(apart_share: float, refused: bool) -> None:
    apart_deg = apart_share * TRUST.largest_apart_deg
    poor = [fit(0.01 * n, 0.2) for n in range(9)]
    assert (distrust(apart_deg, 4.0 * SIGMA_DEG, poor, pointed=True) is not None) == refused


def test_a_wheel_that_jumps_from_spoke_to_spoke_is_refused() -> None:
    """It turns by 11 deg from frame to frame, and five spokes are 72 deg apart: within a range of
    144 deg the angles jump. Truth: no jump of a wheel that turns through, five of this one."""
    wheel = np.deg2rad(11.0 * np.arange(75))
    through = [fit(angle, 0.9) for angle in wheel]
    jumping = [fit(angle % np.deg2rad(144.0), 0.9) for angle in wheel]
    assert jumps(through, np.deg2rad(35.0)) == (0, 0)
    assert jumps([None if n % 9 == 0 else one for n, one in enumerate(through)], 0.6) == (0, 0)
    assert jumps(jumping, np.deg2rad(35.0)) == (5, 5)
    lonely = [one if n % 4 < 2 else None for n, one in enumerate(jumping)]
    assert jumps(lonely, np.deg2rad(35.0)) == (0, 0), "nothing is known around"
    sigma_deg = np.full(75, 0.1)
    for pointed in (False, True):
        assert distrust(0.0, sigma_deg, through, pointed) is None
        assert "jumps" in str(distrust(0.0, sigma_deg, jumping, pointed))


def test_one_jump_against_the_motion_is_refused() -> None:
    """A wheel of six spokes that turns on by 8 deg from frame to frame, and once by one spoke less.
    A jump ahead, as where frames are missing and nobody says so, may be."""
    back, ahead = np.deg2rad([8.0 * np.arange(40), 8.0 * np.arange(40)])
    back[20:] -= np.deg2rad(60.0)
    ahead[20:] += np.deg2rad(60.0)
    behind, before = ([fit(angle, 0.9) for angle in angles] for angles in (back, ahead))
    assert jumps(behind, np.deg2rad(35.0)) == (1, 1)
    assert jumps(before, np.deg2rad(35.0)) == (1, 0)
    sigma_deg = np.full(40, 0.1)
    assert "between frames once" in str(distrust(0.0, sigma_deg, behind, pointed=False))
    assert distrust(0.0, sigma_deg, before, pointed=False) is None


def test_steps_of_a_fast_servo_are_no_jumps() -> None:
    """Steps of 60 deg within two frames, as of 0.08 s per 60 deg at 24 frames/s."""
    steps = np.repeat(np.arange(12) % 2 * 60.0, 6)
    steps = np.convolve(np.pad(steps, 1, mode="edge"), [0.5, 0.5], "valid")
    assert jumps([fit(np.deg2rad(angle), 0.9) for angle in steps], np.deg2rad(35.0)) == (0, 0)
    at_once = np.repeat(np.arange(12) % 2 * 60.0, 6)  # as at 15 frames/s
    assert jumps([fit(np.deg2rad(angle), 0.9) for angle in at_once], np.deg2rad(35.0)) == (0, 0)
