"""What a camera off the axis changes in a track."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.tracking.composite import ObliqueView
from servosight.tracking.core import Flag
from servosight.tracking.methods._along_axis import along_axis, seen_along_axis
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import Frame

CORNERS = np.array([[0.0, -3.0], [40.0, -3.0], [40.0, 3.0], [0.0, 3.0]])
ANGLE_DEG = 30.0 * np.sin(np.arange(40) / 6.0)
TRACK = drawn_part((60.0, 50.0), CORNERS, ANGLE_DEG)
SIGMA_DEG = 0.004
FOUND = ObliqueView(
    found=True,
    tilt_rad=np.deg2rad(15.0),
    terms=np.array([0.1, 0.0, 0.0, 0.0, 0.01]),
    doubts=np.deg2rad(SIGMA_DEG) * np.array([[0.3], [0.0], [0.0], [0.0], [np.sqrt(2.0)]]),
    sigma_rad=np.deg2rad(SIGMA_DEG),
    apart_rad=0.0,
    sides_rad=0.0,
    pivot_px=np.zeros(2),
)


def test_a_tilt_that_is_found_corrects_the_angle_relative_to_the_first_frame() -> None:
    """The angles are counted from 20 deg on by the view; a constant does not count."""
    own_rad = np.deg2rad(ANGLE_DEG + 20.0)
    seen = along_axis(TRACK, FOUND, own_rad, np.array([61.0, 49.5]))
    change_deg = np.rad2deg(0.01 * (np.sin(2 * own_rad) - np.sin(2 * own_rad[0])))
    np.testing.assert_allclose(seen.angle_deg, ANGLE_DEG + change_deg, atol=1e-9)
    left = np.abs(np.sqrt(2.0) * SIGMA_DEG * np.sin(2 * own_rad))
    assert (seen.sigma_deg >= np.hypot(TRACK.sigma_deg, SIGMA_DEG) - 1e-12).all()
    assert (seen.sigma_deg <= np.hypot(TRACK.sigma_deg, 2.0 * left.max())).all()
    assert seen.pivot_px == (61.0, 49.5)
    assert seen.notes[0].startswith("camera 15 deg off the axis of rotation")


def test_a_frame_without_the_part_keeps_the_last_angle_and_its_sigma() -> None:
    own_rad = np.deg2rad(ANGLE_DEG)
    own_rad[10:13] = np.nan
    flags = np.where(np.isnan(own_rad), Flag.LOST, Flag.NONE).astype(np.uint8)
    angle_deg = np.where(np.isnan(own_rad), ANGLE_DEG[9], ANGLE_DEG)
    track = replace(TRACK, flags=flags, angle_deg=angle_deg)
    seen = along_axis(track, FOUND, own_rad, np.zeros(2))
    np.testing.assert_allclose(seen.angle_deg[10:13], seen.angle_deg[9])
    np.testing.assert_array_equal(seen.sigma_deg[10:13], track.sigma_deg[10:13])


def test_what_is_left_of_a_tilt_is_shared_by_all_frames() -> None:
    """The doubt's constant does not count: angles have an offset in any case."""
    own_rad = np.deg2rad(ANGLE_DEG + 20.0)
    seen = along_axis(TRACK, FOUND, own_rad, np.zeros(2))
    expected = np.sqrt(2.0) * SIGMA_DEG * np.sin(2 * own_rad)
    assert seen.shared_deg is not None
    shared = seen.shared_deg[:, 0] * np.sign(seen.shared_deg[0, 0] * expected[0])
    np.testing.assert_allclose(shared, expected - expected.mean(), atol=1e-9)


def test_an_unknown_tilt_is_sigma_alone() -> None:
    unknown = replace(FOUND, found=False, sigma_rad=np.deg2rad(0.3))
    seen = along_axis(TRACK, unknown, np.deg2rad(ANGLE_DEG), np.zeros(2))
    np.testing.assert_array_equal(seen.angle_deg, ANGLE_DEG)
    assert seen.pivot_px == TRACK.pivot_px
    assert seen.sigma_deg == pytest.approx(np.hypot(TRACK.sigma_deg, 0.3), rel=1e-3)
    assert "changes angles by 0.3 deg (one sigma)" in seen.notes[-1]


def test_what_was_assumed_of_the_tilt_is_not_said_beside_one_that_does_not_show() -> None:
    """As that the swing shows none of more than 0.09 deg, beside a sigma of 0.3 deg."""
    track = replace(TRACK, notes=("assumed", "clock"))
    unknown = replace(FOUND, found=False, sigma_rad=np.deg2rad(0.3))
    seen = along_axis(track, unknown, np.deg2rad(ANGLE_DEG), np.zeros(2), "assumed")
    assert seen.notes[:-1] == ("clock",)


def test_of_a_part_that_rests_mostly_at_one_angle_the_other_one_is_the_less_sure() -> None:
    """A tilt makes an error of 0.5 deg between them: about the mean, as an offset is free, 0.45 deg
    in the tenth of the frames that are apart and 0.05 deg in the others, where the rms counts."""
    angle_deg = np.where(np.arange(40) % 10 == 9, 30.0, 0.0)
    doubts = np.deg2rad(0.5) * np.array([[0.0], [0.0], [2.0], [0.0], [0.0]])
    unknown = replace(FOUND, found=False, doubts=doubts, sigma_rad=np.deg2rad(0.15))
    seen = along_axis(
        replace(TRACK, angle_deg=angle_deg), unknown, np.deg2rad(angle_deg), np.zeros(2)
    )
    left = np.sqrt(seen.sigma_deg**2 - TRACK.sigma_deg**2)
    np.testing.assert_allclose(left[angle_deg > 0.0], 0.45, rtol=1e-6)
    np.testing.assert_allclose(left[angle_deg == 0.0], 0.15, rtol=1e-6)


def test_an_unknown_tilt_that_changes_less_than_an_angle_may_be_off_is_not_spoken_of() -> None:
    unknown = replace(FOUND, found=False, sigma_rad=np.deg2rad(0.2))
    assert along_axis(TRACK, unknown, np.deg2rad(ANGLE_DEG), np.zeros(2)).notes == TRACK.notes


def test_a_part_that_no_sampled_frame_shows_is_left_as_it_is() -> None:
    sample = FrameSample(lambda image: image)
    for number in range(TRACK.frames):
        sample.add(Frame(number, number / 100.0, np.zeros((60, 80), np.uint8)))
    lost = replace(TRACK, flags=np.full(TRACK.frames, Flag.LOST, np.uint8))
    assert seen_along_axis(lost, sample, lost.outline_px, np.array(lost.pivot_px)) is lost
