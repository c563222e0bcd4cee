"""Which samples fit, validate and test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose.residuals import FIT, TEST, VALIDATION
from servosight.diagnose.selection import Split
from servosight.models.core import Recording


def recording(duration_s: float, name: str = "run", rate_hz: float = 60.0) -> Recording:
    """A sine of 1 Hz, so that every second is like every other."""
    time_s = 3.4 + np.arange(round(duration_s * rate_hz)) / rate_hz
    angle = 5.0 * np.sin(2.0 * np.pi * time_s)
    return Recording(name, time_s, angle, time_s, angle)


def by_block(one: Recording, uses: np.ndarray) -> list[int]:
    """The use of each block of one second; each block has one."""
    second = np.floor(one.time_s - one.time_s[0] + 1e-9).astype(int)
    found = [np.unique(uses[second == block]) for block in range(second[-1] + 1)]
    assert all(each.size == 1 for each in found)
    return [int(each[0]) for each in found]


@pytest.mark.parametrize("choice", [0, 1])
def test_of_six_blocks_four_are_fitted_one_validates_and_one_tests(choice: int) -> None:
    one = recording(12.0)
    split = Split.of([one], choice=choice)
    blocks = by_block(one, split.uses[0])
    assert blocks[0] == FIT
    for six in (blocks[:6], blocks[6:]):
        assert sorted(six) == [FIT, FIT, FIT, FIT, VALIDATION, TEST]
    assert blocks[:6] == blocks[6:]
    assert blocks.index(TEST) == blocks.index(VALIDATION) + 3
    assert split.warnings == ()
    np.testing.assert_array_equal(split.masks[0], split.uses[0] == FIT)
    np.testing.assert_array_equal(split.untested[0], split.uses[0] != TEST)


def test_the_choices_hold_out_different_blocks() -> None:
    one = recording(12.0)
    first, second = (Split.of([one], choice=choice).uses[0] for choice in (0, 1))
    assert not np.any((first != FIT) & (second != FIT))
    np.testing.assert_array_equal(Split.of([one], choice=9).uses[0], second)


def test_what_is_seen_once_is_fitted() -> None:
    """One large move in the third second, or in the second: the fitted samples keep it."""
    one = recording(12.0)
    time_s = one.time_s - one.time_s[0]
    for start in (1.0, 2.0):
        moved = 20.0 * np.exp(-(((time_s - start - 0.5) / 0.1) ** 2))
        split = Split.of([replace(one, angle_deg=moved)])
        assert split.masks[0][np.argmax(moved)]


@pytest.mark.parametrize("offset_deg", [0.0, 100.0])
@pytest.mark.parametrize(("wide_s", "hertz"), [(0.1, 20.0), (0.3, 12.0)])
@pytest.mark.parametrize("swing_s", [1.5, 2.5])
def test_angle_speed_and_acceleration_count_alike(
    swing_s: float, wide_s: float, hertz: float, offset_deg: float
) -> None:
    """A swing has most of the angle and of the speed, a tremble most of the acceleration.

    Only one of the two seconds can be fitted: that which loses less of the three shares, whatever
    their units and the zero of the angle.
    """
    one = recording(12.0)
    time_s = one.time_s - one.time_s[0]
    swing = 20.0 * np.exp(-(((time_s - swing_s) / wide_s) ** 2))
    tremble = 0.5 * np.sin(2.0 * np.pi * hertz * time_s) * (np.abs(time_s - (4.0 - swing_s)) < 0.3)
    split = Split.of([replace(one, angle_deg=offset_deg + swing + tremble)])
    assert split.masks[0][np.argmax(swing)]


def test_a_second_and_a_half_has_something_to_validate_on() -> None:
    split = Split.of([recording(1.6)])
    assert set(split.uses[0]) == {FIT, VALIDATION}
    assert set(Split.of([recording(0.9)]).uses[0]) == {FIT}


def test_two_samples_at_the_end_are_no_block_to_validate_on() -> None:
    """Two seconds and two samples: the block of a second is held out instead."""
    split = Split.of([recording(2.03)])
    assert np.sum(split.uses[0] == VALIDATION) >= 50


def test_validation_recordings_alternate_between_validation_and_test() -> None:
    one, other = recording(5.0), recording(7.0, "other")
    split = Split.of([one], [other])
    assert set(split.uses[0]) == {FIT}
    assert by_block(other, split.carried_uses[0]) == [VALIDATION, TEST] * 3 + [VALIDATION]
    assert split.tested == ()


def test_test_recordings_are_all_of_the_test() -> None:
    one, other, third = recording(7.0), recording(7.0, "other"), recording(7.0, "third")
    split = Split.of([one], [other], [third])
    assert set(split.uses[0]) == {FIT}
    assert set(split.carried_uses[0]) == {VALIDATION}
    assert split.tested == (third,)
    alone = Split.of([one], (), [third])
    assert by_block(one, alone.uses[0]).count(VALIDATION) == 2
    assert TEST not in alone.uses[0]
    assert alone.warnings == ()


def test_too_short_for_three_falls_back_to_two_with_a_warning() -> None:
    for short in (recording(2.6, "short"), recording(4.2, "short")):
        split = Split.of([short])
        assert set(split.uses[0]) == {FIT, VALIDATION}
        assert split.warnings[0].startswith("short: too short")
    split = Split.of([recording(6.0)], [recording(1.3, "short")])
    assert set(split.carried_uses[0]) == {VALIDATION}
    assert "short: too short" in split.warnings[0]


def test_the_warning_names_the_data_that_the_reported_error_is_of() -> None:
    long, short, shortest = recording(12.0), recording(2.6, "short"), recording(0.9, "shortest")
    (alone,) = Split.of([shortest]).warnings
    assert alone.endswith("the error of the fitted data, which chose the effects as well")
    (validated,) = Split.of([short]).warnings
    assert validated.endswith("the validation error, of the data that chose the effects")
    (beside,) = Split.of([long, short]).warnings
    assert beside.endswith("that of the test data of the other recordings")


def test_half_a_second_is_enough_to_test_on() -> None:
    """Of 4.6 s, the fifth block can be tested on only if the second validates."""
    one = recording(4.6)
    split = Split.of([one])
    assert split.warnings == ()
    assert by_block(one, split.uses[0]) == [FIT, VALIDATION, FIT, FIT, TEST]
