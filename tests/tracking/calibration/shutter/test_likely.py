"""What is to be expected of a readout, where it shows and where it does not."""

from __future__ import annotations

import pytest

from servosight.tracking.calibration.shutter._likely import LikelyReadout


@pytest.mark.parametrize("doubt", [0.03, 0.1, 0.15])
def test_a_readout_is_found_at_four_sigma_and_hardly_expected_at_one(doubt: float) -> None:
    """Half of the cameras have none: up to 0.15 of a frame time, one sigma of it is unlikely."""
    near, far = LikelyReadout.of(doubt, doubt), LikelyReadout.of(4.0 * doubt, doubt)
    assert near.rolls < 0.35
    assert near.size < 0.5 * doubt
    assert far.rolls > 0.95
    assert far.size == pytest.approx(4.0 * doubt, rel=0.05)


def test_a_readout_from_the_last_row_up_is_the_less_likely_one() -> None:
    """At two sigma, where one in twenty cameras is held upside down."""
    upwards, downwards = LikelyReadout.of(-0.6, 0.3), LikelyReadout.of(0.6, 0.3)
    assert upwards.rolls < 0.5 < downwards.rolls
