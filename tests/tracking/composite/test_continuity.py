"""A part that looks the same at several angles is followed only where its motion tells which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.tracking.composite import PoseFit, leap_deg, longest_sure, without_false_turns
from servosight.tracking.composite._continuity import repeats_rad
from servosight.tracking.composite._sighting import Sighting

STEPS_DEG = 45.0 * np.tanh(3.0 * np.sin(np.arange(120) / 4.5)) / np.tanh(3.0)
SPOKES = np.deg2rad([-90.0, 90.0, 180.0])


def fits_at(angle_deg: Array, hidden: range = range(0)) -> list[PoseFit | None]:
    """Fits at these angles, none in hidden frames."""
    return [
        None if n in hidden else
        PoseFit(float(a), np.zeros(2), np.zeros((3, 3)), 1.0, 0.9, 1.0, 0.0, 0.0, 0.1, 0.0, 0.0)
        for n, a in enumerate(np.deg2rad(angle_deg))
    ]  # fmt: skip


def test_steps_of_a_wheel_in_full_view_are_followed() -> None:
    """Truth: it turns by up to 28 deg from frame to frame, and four spokes are 90 deg apart."""
    assert np.abs(np.diff(STEPS_DEG)).max() > 25.0
    assert longest_sure(fits_at(STEPS_DEG), [SPOKES] * 120).all()


def test_a_spoke_taken_for_the_next_one_ends_the_run() -> None:
    """Truth: nine frames are 90 deg off; what is followed is a run of frames on one side."""
    wrong = STEPS_DEG.copy()
    wrong[50:59] -= 90.0
    assert longest_sure(fits_at(wrong), [SPOKES] * 120).tolist() == [n >= 59 for n in range(120)]


def test_a_wheel_that_jumps_from_spoke_to_spoke_is_not_followed_beyond() -> None:
    """Truth: it turns on by 11 deg from frame to frame. Five spokes are 72 deg apart, so that a
    search within a range of 144 deg takes another one each 13th frame."""
    wheel_deg = 11.0 * np.arange(75)
    spokes = np.deg2rad([-144.0, -72.0, 72.0, 144.0])
    assert longest_sure(fits_at(wheel_deg), [spokes] * 75).all()
    assert longest_sure(fits_at(wheel_deg % 144.0), [spokes] * 75).sum() == 14


@pytest.mark.parametrize(("hidden", "joined"), [(1, True), (6, False)])
def test_frames_that_hide_a_turn_from_spoke_to_spoke_end_the_run(hidden: int, joined: bool) -> None:
    """A step takes four frames: one hidden frame hides none, six may."""
    gap = range(60, 60 + hidden)
    sure = longest_sure(fits_at(STEPS_DEG, gap), [SPOKES] * 120)
    assert sure[0] == joined or sure[-1] == joined
    assert sure.sum() == (120 if joined else 60)


def test_a_part_with_a_mark_is_followed_through_any_gap() -> None:
    """A hand that looks like the part in the frames beside it is no angle at which it repeats."""
    none = np.empty(0)
    like_a_hand = [np.array([0.9]) if 55 < n < 75 else none for n in range(120)]
    for rivals in ([none] * 120, like_a_hand):
        assert longest_sure(fits_at(STEPS_DEG, range(60, 70)), rivals).sum() == 120
    assert not longest_sure([None] * 3, [none] * 3).any()


def test_turns_that_recur_are_those_of_the_spokes() -> None:
    """Truth: 120 deg, seen within 2 deg and in one direction or the other."""
    rng = np.random.default_rng(2)
    seen = [np.deg2rad(rng.permutation([-120.0, 120.0]) + rng.normal(0, 2, 2))[: 1 + n % 2]
            for n in range(40)]  # fmt: skip
    seen[7] = np.append(seen[7], 0.8)
    assert np.rad2deg(repeats_rad(seen)) == pytest.approx([-120.0, 120.0], abs=4.0)


def test_a_hand_that_gains_more_is_tried_after_the_angle_expected() -> None:
    """Truth: the part at 10 deg, at half of the gain of a hand at 100 deg; a spoke at -80 deg."""
    angle = np.deg2rad(np.arange(-180.0, 180.0, 1.0))

    def lobe(deg: float) -> Array:
        return np.asarray(
            np.exp(-0.5 * (np.angle(np.exp(1j * (angle - np.deg2rad(deg)))) / 0.05) ** 2)
        )

    gain = 0.5 * lobe(10.0) + lobe(100.0) + 0.48 * lobe(-80.0) - 0.1
    seen = Sighting(angle, gain, (np.deg2rad(8.0), 0.5))
    assert np.rad2deg(seen.likeliest) == pytest.approx([10.0, 100.0], abs=0.01)
    assert np.rad2deg(seen.most_likely) == pytest.approx(100.0, abs=0.01)
    assert np.rad2deg(seen.rivals(np.deg2rad(10.0))) == pytest.approx([-90.0, 90.0], abs=0.01)
    clear = Sighting(angle, 0.9 * lobe(10.0) + lobe(100.0) - 0.1, (np.deg2rad(8.0), 0.5))
    assert np.rad2deg(clear.likeliest) == pytest.approx([10.0], abs=0.01)
    assert Sighting(angle, gain - 2.0, None).likeliest == ()


SWING_DEG = 170.0 * np.sin(np.arange(120) / 6.0)


def hidden_behind(fits: list[PoseFit | None], frames: range) -> list[PoseFit | None]:
    """The same where something else in these frames leaves ten times as much as usual."""
    return [
        replace(fit, noise=10.0) if fit is not None and n in frames else fit
        for n, fit in enumerate(fits)
    ]


@pytest.mark.parametrize("turns", [-1, 1])
def test_a_turn_around_the_pivot_that_someone_behind_a_part_led_to_is_taken_back(
    turns: int,
) -> None:
    """Truth: a swing through 340 deg; over six frames a search follows someone around the pivot,
    then sees the part again, a whole turn off."""
    wrong = SWING_DEG.copy()
    wrong[54:60] = wrong[53] + 10.0 * turns * np.arange(1, 7)
    wrong[60:] += 360.0 * turns
    assert abs(wrong[60] - wrong[59]) > 75.0
    found = without_false_turns(hidden_behind(fits_at(wrong), range(54, 60)))
    assert [n for n, fit in enumerate(found) if fit is None] == [54, 55, 56, 57, 58, 59]
    angle_deg = np.rad2deg([fit.angle_rad for fit in found if fit is not None])
    np.testing.assert_allclose(angle_deg, np.delete(SWING_DEG, range(54, 60)), atol=1e-9)


def test_a_part_that_turns_on_behind_someone_keeps_its_turns() -> None:
    """Truth: 50 deg from frame to frame, six of which show something else as well."""
    fits = hidden_behind(fits_at(50.0 * np.arange(60)), range(30, 36))
    assert without_false_turns(fits) == fits


def test_nothing_is_changed_where_no_frame_leaves_more_than_usual() -> None:
    fits = fits_at(SWING_DEG, range(40, 44))
    assert without_false_turns(fits) == fits
    assert without_false_turns([None, None]) == [None, None]


@pytest.mark.parametrize(
    ("angle_deg", "rate_hz", "expected"),
    [
        ([0.0, 1.0, 1.5, 61.0, 60.5, 60.0], 60.0, 59.5),
        ([0.0, 1.0, 1.5, 61.0, 60.5, 60.0], 15.0, 0.0),  # as fast as a servo
        ([0.0, 1.0, 20.0, 61.0, 100.0, 120.0], 60.0, 0.0),  # as fast before and after
        ([0.0, 1.0, 1.5, np.nan, 61.0, 60.5, 60.0], 60.0, 0.0),  # not seen in between
        ([0.0, 0.0, 61.0, 0.0, 0.0], 60.0, 0.0),  # one wrong frame
        ([0.0, 60.0], 60.0, 0.0),
    ],
)
def test_what_leaps_faster_than_any_servo_and_rests_before_and_after(
    angle_deg: list[float], rate_hz: float, expected: float
) -> None:
    time_s = np.arange(len(angle_deg)) / rate_hz
    assert leap_deg(time_s, np.array(angle_deg)) == expected
