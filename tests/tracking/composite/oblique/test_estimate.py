"""The tilt from the poses of a part, by poses that are known."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite.oblique._estimate import (
    TiltEstimate,
    estimated_tilt,
)
from servosight.tracking.composite.oblique._plane import ExpectedTilts
from servosight.tracking.fit import PoseSensitivity, turned_errors

FAR_PX = 90.0
ANGLE_RAD = np.linspace(-0.5, 0.5, 40)
PACE_PX = 10.0 * np.cos(np.pi * ANGLE_RAD)  # slow at both ends, as a swing is
EXPECTED = ExpectedTilts.of(FAR_PX, 480.0, np.zeros(2))
TILTED = int(np.argmin(np.abs(EXPECTED.tilt_rad - np.deg2rad(16.0)) + (
    np.abs(EXPECTED.shape_px[:, 2:]).sum(1)
) + np.abs(EXPECTED.shape_px[:, 0] + 1.7)))  # fmt: skip
TRUTH_PX = EXPECTED.shape_px[TILTED]


TURN = np.full(6, 1.0 / FAR_PX)


def poses_of(
    shape_px: Array, by_blur_px: float = 0.0, angle_rad: Array = ANGLE_RAD,
) -> list[PoseSensitivity]:  # fmt: skip
    """What pictures at these angles show of a plane that is off by a shape (4,), of a part whose
    picture blur stretches by ``by_blur_px`` for each pixel of its speed; each to 0.1 px."""
    turned = turned_errors(angle_rad, 6)
    seen = (np.eye(6) - turned @ turned.transpose(0, 2, 1).mean(0)) @ np.r_[0.0, 0.0, shape_px]
    pace_px = 10.0 * np.cos(np.pi * angle_rad)
    own = by_blur_px * (pace_px - pace_px.mean())[:, None] * turned[:, :, 2]
    weight = np.eye(6) / 0.1**2
    return [PoseSensitivity(weight, weight @ one, TURN) for one in seen + own]


def estimate(poses: list[PoseSensitivity], angle_rad: Array = ANGLE_RAD) -> TiltEstimate:
    pace_px = 10.0 * np.cos(np.pi * angle_rad)
    return estimated_tilt(angle_rad, pace_px, poses, np.zeros(4), EXPECTED)


def test_a_part_that_blur_stretches_does_not_hide_a_tilt() -> None:
    """By 0.06 px for each pixel of speed, as a needle's tip that fades, which made three quarters
    of the stretch of one 16 deg off the axis disappear."""
    found = estimate(poses_of(TRUTH_PX, by_blur_px=0.06))
    sure = found.covariance[:2, :2] + 0.1**2 * np.eye(2)
    away = found.shape_px[:2] - TRUTH_PX[:2]
    assert away @ np.linalg.solve(sure, away) < 9.0
    assert np.hypot(*away) < 0.35 * np.hypot(*TRUTH_PX[:2])


def test_pictures_at_one_angle_count_as_one() -> None:
    """They show the same error of light and codec, as often as they are taken."""
    often = np.sort(np.r_[ANGLE_RAD, np.full(200, ANGLE_RAD[0])])
    rng = np.random.default_rng(5)

    def noisy(angle_rad: Array) -> list[PoseSensitivity]:
        return [
            PoseSensitivity(one.weight, one.right + one.weight @ rng.normal(0.0, 0.1, 6), one.turn)
            for one in poses_of(np.zeros(4), angle_rad=angle_rad)
        ]

    few, many = estimate(noisy(ANGLE_RAD)), estimate(noisy(often), often)
    assert np.trace(many.covariance[:2, :2]) > 0.5 * np.trace(few.covariance[:2, :2])


def test_poses_that_no_tilt_explains_leave_the_angles_as_uncertain_as_they_contradict_it() -> None:
    """A stretch with a perspective that no lens makes of it."""
    odd = estimate(poses_of(np.array([-1.7, 0.0, 9.0, 9.0])))
    plain = estimate(poses_of(TRUTH_PX))
    assert odd.sigma_rad > 3.0 * plain.sigma_rad


def test_a_tilt_explains_its_own_poses_up_to_chance_and_those_of_no_other_cause() -> None:
    """Those of a camera on the axis need none; the odd ones are as above."""
    assert estimate(poses_of(TRUTH_PX)).explained
    assert not estimate(poses_of(np.zeros(4))).explained
    assert not estimate(poses_of(np.array([-1.7, 0.0, 9.0, 9.0]))).explained
