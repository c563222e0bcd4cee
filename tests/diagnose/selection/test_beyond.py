"""Which validation samples choose: those that move as something fitted does."""

from __future__ import annotations

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
