"""What of a motion counts when stretches of a long recording are chosen."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.diagnose.selection import stretches
from servosight.diagnose.selection._stretches import (
    BINS,
    STRETCH_S,
    _binned,
    _covering,
    _features,
    _rows,
    _starts,
)
from servosight.identify.problem import MOST_SAMPLES
from servosight.models.core import Array, Recording

ANGLE, SPEED, ACCELERATION, REVERSAL = (slice(BINS * i, BINS * (i + 1)) for i in range(4))


def moved(angle_deg: Array, time_s: Array) -> Recording:
    return Recording("a", time_s, angle_deg, time_s, angle_deg)


def features(angle_deg: Array, time_s: Array) -> Array:
    recording = moved(angle_deg, time_s)
    return _features(recording, _starts(recording))


def test_values_are_counted_in_twelve_bins_of_one_width() -> None:
    for low, high in ((0.0, 120.0), (-7.0, -1.0), (1e-6, 2e-6)):
        counts = np.bincount(_binned(np.linspace(low, high, 12_001)), minlength=12)
        assert counts.size == 12
        np.testing.assert_allclose(counts, 1000, atol=15)


def test_a_thousandth_at_either_end_shares_the_outermost_bins() -> None:
    """Two spikes among a thousand values widen no bin."""
    values = np.concatenate([np.linspace(0.0, 1.0, 4_000), [-1e3, 1e3]])
    counts = np.bincount(_binned(values))
    np.testing.assert_allclose(counts, 4_000 / 12, atol=8)


def test_no_value_and_one_value_have_bins() -> None:
    assert _binned(np.zeros(0)).size == 0
    assert _binned(np.full(3, 5.0)).tolist() == [0, 0, 0]


def test_each_kind_of_motion_adds_up_to_one() -> None:
    time_s = np.arange(0.0, 38.0, 0.02)
    table = features(10.0 * np.sin(2.0 * time_s), time_s)
    assert table.shape == (3, 4 * BINS)
    for kind in (ANGLE, SPEED, ACCELERATION, REVERSAL):
        assert table[:, kind].sum() == pytest.approx(1.0)
        np.testing.assert_allclose(table[:, kind].sum(axis=1), 1.0 / 3.0, atol=0.05)


def test_a_motion_without_reversals_has_none() -> None:
    time_s = np.arange(0.0, 26.0, 0.02)
    table = features(time_s**2, time_s)
    assert table[:, REVERSAL].sum() == 0.0
    assert table[:, ANGLE].sum() == pytest.approx(1.0)


def test_a_reversal_counts_at_its_angle_and_in_its_stretch() -> None:
    """One at 10 deg in the first stretch, one at -20 deg in the last."""
    time_s = np.arange(0.0, 37.5, 0.02)
    angle = np.interp(time_s, [0.0, 5.0, 35.0, 37.5], [0.0, 10.0, -20.0, -15.0])
    table = features(angle, time_s)[:, REVERSAL]
    assert table[0].tolist() == [0.0] * (BINS - 1) + [0.5]
    assert table[2].tolist() == [0.5] + [0.0] * (BINS - 1)


@pytest.mark.parametrize(("ripple_deg", "counts"), [(0.0015, False), (0.03, True)])
def test_motion_slower_than_a_fiftieth_reverses_nothing(ripple_deg: float, counts: bool) -> None:
    """A rest that ripples at 12 rad/s, between two ways at 1 deg/s: at 0.018 and 0.36 deg/s."""
    time_s = np.arange(0.0, 26.0, 0.02)
    angle = np.interp(time_s, [0.0, 8.0, 18.0, 26.0], [0.0, 8.0, 8.0, 16.0])
    resting = (time_s > 8.0) & (time_s < 18.0)
    angle = angle + ripple_deg * np.where(resting, np.sin(12.0 * (time_s - 8.0)), 0.0)
    assert bool(features(angle, time_s)[:, REVERSAL].any()) is counts


def test_samples_before_the_first_stretch_and_behind_the_last_do_not_count() -> None:
    """Of 27 s the first and the last two: there alone the angle is beyond 1 deg."""
    time_s = np.arange(0.0, 27.0, 0.02)
    inside = (time_s >= 1.0) & (time_s < 25.0)
    angle = np.where(inside, np.sin(time_s), 30.0)
    table = features(angle, time_s)[:, ANGLE]
    assert table[:, 1:].sum() == 0.0
    assert table[:, 0].sum() == pytest.approx(1.0)


def test_the_motion_is_averaged_over_a_hundredth_of_a_second() -> None:
    """So that more samples of a motion are no more motion."""
    coarse_s, fine_s = np.arange(0.0045, 26.0, 0.01), np.arange(0.0, 26.0, 0.001)
    coarse, fine = (features(10.0 * np.sin(time_s), time_s) for time_s in (coarse_s, fine_s))
    np.testing.assert_allclose(fine, coarse, atol=0.01)


def test_what_is_rare_is_chosen_before_more_of_the_same() -> None:
    common, rare = [0.5, 0.0], [0.3, 0.1]
    assert _covering(np.array([common, rare, common]), 2) == [1, 0]
    assert _covering(np.array([common, common, rare]), 3) == [2, 0, 1]


def test_stretches_lie_side_by_side_behind_a_second_of_lead() -> None:
    time_s = np.arange(100.0, 137.5, 0.02)
    np.testing.assert_allclose(
        _starts(moved(time_s, time_s)), 101.0 + STRETCH_S * np.arange(3), atol=1e-9
    )
    assert _starts(moved(time_s[:600], time_s[:600])).size == 0


def test_rows_are_changes_of_the_command_and_samples_as_thinned_as_a_fits() -> None:
    few, many = np.arange(100.0), np.arange(MOST_SAMPLES + 50.0)
    held = np.repeat([0.0, 1.0, 2.0, 2.0], 25)
    assert _rows(Recording("a", few, held, few, few)) == 3 + 100
    assert _rows(Recording("a", few, held, few, few, hold="linear")) == 100 + 100
    assert _rows(Recording("a", few, held, many, many)) == 3 + MOST_SAMPLES


def test_so_many_stretches_are_taken_as_need_no_sample_left_out() -> None:
    """Half of the rows of 400 s are 200 s: fifteen stretches with their second of lead."""
    time_s = np.arange(0.0, 400.0, 0.02)
    angle = np.sin(time_s)
    (spans,), _ = stretches([moved(angle, time_s)], 20_000)
    assert len(spans) == 15
    (spans,), _ = stretches([moved(angle, time_s)], 10)
    assert len(spans) == 1
