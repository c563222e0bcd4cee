"""Which validation samples choose: those that move as something fitted does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose.residuals import TEST, VALIDATION, Judged
from servosight.diagnose.selection import Split
from servosight.models.core import Array, Recording

TIME_S = np.arange(0.0, 8.0, 0.01)
SINE = np.sin(2.0 * np.pi * 0.5 * TIME_S)


def run(angle_deg: Array) -> Recording:
    return Recording("run", TIME_S, angle_deg, TIME_S, angle_deg, hold="linear")


def wider_from(start_s: float) -> Recording:
    """Swings by 10 deg at first, and by 30 deg from then on."""
    return run(np.where(start_s > TIME_S, 10.0, 30.0) * SINE)


def test_samples_of_swings_that_are_not_fitted_do_not_choose() -> None:
    """From 6 s on, in which the command swings by 60 deg where the fitted one swings by 20."""
    split = Split.of([run(10.0 * SINE)], [wider_from(6.0)], [run(SINE)])
    (beyond,) = split.carried_beyond
    assert not beyond[TIME_S < 5.4].any()
    assert beyond[TIME_S > 6.1].all()


def ahead(angle_deg: Array, start_s: float, by_deg: float = 15.0) -> Recording:
    """A command that is ``by_deg`` ahead of the angle for 0.3 s, and 2 deg at any other time."""
    during = np.abs(TIME_S - start_s - 0.15) < 0.15
    command_deg = angle_deg + np.where(during, by_deg, 2.0)
    return Recording("run", TIME_S, command_deg, TIME_S, angle_deg, hold="linear")


def test_samples_of_larger_position_errors_do_not_choose_nor_what_follows() -> None:
    """The servo turns back at 6.5 and at 7.5 s: what a limit has delayed shows until then."""
    split = Split.of([ahead(30.0 * SINE, 6.0, 12.0)], [ahead(30.0 * SINE, 6.0)], [run(SINE)])
    (beyond,) = split.carried_beyond
    assert not beyond[TIME_S < 5.98].any()
    assert beyond[(TIME_S > 6.0) & (TIME_S < 7.48)].all()
    assert not beyond[TIME_S > 7.52].any()


def test_a_zero_of_its_own_is_no_position_error() -> None:
    """As of a camera that was turned by 40 deg before the second recording."""
    other = ahead(30.0 * SINE, 6.0, 12.0)
    other = replace(other, command_deg=other.command_deg + 40.0)
    assert not Split.of([ahead(30.0 * SINE, 6.0)], [other], [run(SINE)]).carried_beyond[0].any()


def test_a_servo_at_rest_has_settled() -> None:
    angle_deg = 30.0 * np.where(TIME_S < 6.5, SINE, 1.0)
    split = Split.of([ahead(angle_deg, 6.0, 12.0)], [ahead(angle_deg, 6.0)], [run(SINE)])
    (beyond,) = split.carried_beyond
    assert beyond[(TIME_S > 6.0) & (TIME_S < 6.45)].all()
    assert not beyond[TIME_S > 6.6].any()


def test_a_larger_position_error_at_a_lower_gain_asks_for_no_more() -> None:
    """15 deg at half the gain are a torque of 7.5 deg."""
    low = replace(ahead(30.0 * SINE, 6.0), relative_gain=0.5)
    for most_deg, expected in ((8.0, False), (6.0, True)):
        fitted = [ahead(30.0 * SINE, 6.0, most_deg), replace(low, angle_deg=low.command_deg)]
        split = Split.of(fitted, [low], [run(SINE)])
        assert split.carried_beyond[0].any() == expected


def test_where_too_few_are_left_what_follows_chooses() -> None:
    """A servo that turns back after 6 s: 0.3 of 8 s lie beyond."""
    slow = 30.0 * np.sin(2.0 * np.pi * 0.04 * TIME_S)
    split = Split.of([ahead(slow, 1.0, 12.0)], [ahead(slow, 1.0, 13.5)], [run(SINE)])
    assert 25 <= split.carried_beyond[0].sum() <= 35


@pytest.mark.parametrize("start_s", [0.0, 3.0])
def test_where_most_samples_are_beyond_all_choose(start_s: float) -> None:
    split = Split.of([run(10.0 * SINE)], [wider_from(start_s)], [run(SINE)])
    assert not split.carried_beyond[0].any()


def test_samples_for_the_test_do_not_count_to_what_is_enough() -> None:
    """The first 2 s validate and lie within, or the last 2 s, and lie beyond."""
    split = Split.of([run(10.0 * SINE)], [wider_from(6.0)])
    first = np.where(TIME_S < 2.0, VALIDATION, TEST).astype(np.int8)
    for uses, enough in ((first, True), (first[::-1], False)):
        used = Split(split.recordings, split.uses, split.carried, (uses,))
        assert used.carried_beyond[0].any() == enough


def test_blocks_of_a_fitted_recording_all_choose() -> None:
    split = Split.of([wider_from(6.0)])
    assert split.carried_beyond == ()
    assert Split.of([run(SINE)], [run(SINE)]).carried_beyond[0].sum() == 0


def test_what_does_not_choose_is_set_apart_as_the_test_is() -> None:
    uses = np.full(TIME_S.size, VALIDATION, np.int8)
    judged = Judged(run(SINE), np.zeros(TIME_S.size), uses, np.asarray(TIME_S >= 6.0))
    assert np.array_equal(judged.choosing.uses == TEST, TIME_S >= 6.0)
    assert np.all(judged.uses == VALIDATION)
