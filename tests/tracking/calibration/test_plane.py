"""Lens, plane and what a swing tells of it: points with known truth, no pictures."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.tracking.calibration._swing import Swing, calibrate_swing
from servosight.tracking.calibration._swing_features import Tracks
from servosight.tracking.core import Lens, MotionPlane, like_picture, mapped, turning
from servosight.tracking.core._plane import jacobian

SHAPE = (480, 640)
PIVOT = np.array([230.0, 240.0])
FOCAL_PX, AWAY = 1400.0, 500.0


def seen_from(yaw_deg: float, pitch_deg: float) -> Array:
    """A plane's points about its pivot to pixels of a pinhole that looks at the pivot (3, 3)."""
    yaw, pitch = np.deg2rad([yaw_deg, pitch_deg])
    about_y = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    about_x = np.array(
        [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
    )
    turn = about_x @ about_y
    camera = np.array([[FOCAL_PX, 0, PIVOT[0]], [0, FOCAL_PX, PIVOT[1]], [0, 0, 1]])
    return camera @ np.column_stack([turn[:, 0], turn[:, 1], (0.0, 0.0, AWAY)])


def swing_of(
    view: Array, angles_deg: Array, noise_px: float, seed: int = 1, lens: Lens | None = None
) -> Swing | None:
    """What 150 points tell that turn counter-clockwise as seen by these angles."""
    rng = np.random.default_rng(seed)
    points = rng.uniform((10.0, -8.0), (90.0, 8.0), (150, 2))
    xy, point, frame = [], [], []
    for number, angle in enumerate(np.deg2rad(angles_deg)):
        cos, sin = np.cos(angle), np.sin(angle)
        seen = mapped(view, points @ np.array([[cos, -sin], [sin, cos]]))
        xy.append(lens.bent(seen) if lens is not None else seen)
        point.append(np.arange(150))
        frame.append(np.full(150, number))
    noisy = np.vstack(xy) + noise_px * rng.standard_normal((150 * len(xy), 2))
    tracks = Tracks(noisy, np.concatenate(point), np.concatenate(frame), SHAPE)
    return calibrate_swing(tracks, lens)


def test_a_lens_is_undone_and_done_again() -> None:
    lens = Lens((900.0, 905.0), (310.0, 245.0), (-0.25, 0.08, 1e-3, -5e-4, 0.01))
    rng = np.random.default_rng(0)
    seen = rng.uniform((0, 0), (639, 479), (500, 2))
    assert np.abs(lens.bent(lens.straight(seen)) - seen).max() < 1e-6
    assert np.abs(lens.straight(seen) - seen).max() > 3.0
    plane = MotionPlane(like_picture(np.linalg.inv(seen_from(20, 10)), PIVOT), lens)
    assert np.abs(plane.to_picture(plane.of_picture(seen)) - seen).max() < 1e-6


def test_the_plane_agrees_with_the_picture_at_its_centre() -> None:
    for mirror in (1.0, -1.0):
        matrix = np.diag([mirror, 1.0, 1.0]) @ np.linalg.inv(seen_from(25, -15))
        onto = like_picture(matrix, PIVOT)
        assert np.abs(mapped(onto, PIVOT[None])[0] - PIVOT).max() < 1e-9
        slope = jacobian(onto, PIVOT)
        assert np.linalg.det(slope) == pytest.approx(1.0)
        assert np.abs(slope - slope.T).max() < 1e-9
    assert MotionPlane(onto).tilt_deg(PIVOT) == pytest.approx(29.0, abs=0.3)
    assert MotionPlane().is_picture
    assert not MotionPlane(onto).is_picture


@pytest.mark.parametrize(("yaw", "pitch"), [(30, 0), (0, 30), (-21, 21), (45, 0)])
def test_a_swing_tells_plane_pivot_and_angles(yaw: float, pitch: float) -> None:
    """Truth: the angles drawn. Bound: 4 sigma as told, and 0.02 deg."""
    angles = np.array([0.0, -18, -12, -6, 4, 9, 14, 20])
    swing = swing_of(seen_from(yaw, pitch), angles, noise_px=0.1)
    assert swing is not None
    assert swing.significant
    error = np.rad2deg(swing.angle_rad) - angles
    sigma = np.rad2deg(np.hypot(swing.doubt_rad, 1e-5))
    assert np.abs(error).max() < 0.02
    assert np.abs(error[1:] / np.hypot(sigma[1:], 0.001)).max() < 4.0
    assert np.std(np.rad2deg(swing.rigid_rad) - angles) > 0.1
    assert np.hypot(*(np.array(swing.pivot_px) - PIVOT)) < 0.1
    true = np.rad2deg(np.arccos(np.cos(np.deg2rad(yaw)) * np.cos(np.deg2rad(pitch))))
    assert swing.plane.tilt_deg(PIVOT) == pytest.approx(true, abs=0.5)


def test_doubt_of_a_swing_is_what_repeated_noise_shows() -> None:
    """Over 40 draws of the noise, error over sigma has an rms of one within a quarter."""
    angles = np.array([0.0, -15, -8, 5, 12, 18])
    ratio = []
    for seed in range(40):
        swing = swing_of(seen_from(30, 0), angles, 0.2, seed)
        assert swing is not None
        error = swing.angle_rad - np.deg2rad(angles)
        ratio.append(error[[1, 5]] / swing.doubt_rad[[1, 5]])
    assert 0.75 < np.sqrt(np.mean(np.square(ratio))) < 1.3


def test_a_camera_on_the_axis_and_a_small_swing_tell_no_plane() -> None:
    axis = swing_of(seen_from(0, 0), np.linspace(0, 20, 8), 0.1)
    assert axis is not None
    assert not axis.significant
    small = swing_of(seen_from(10, 0), np.linspace(0, 1.5, 8), 0.1)
    assert small is None or not small.significant


def test_a_known_lens_goes_before_the_swing() -> None:
    lens = Lens((FOCAL_PX, FOCAL_PX), (320.0, 240.0), (-0.4, 0.0, 0.0, 0.0, 0.0))
    angles = np.linspace(-20, 20, 9)
    angles -= angles[0]
    swing = swing_of(seen_from(30, 0), angles, 0.05, lens=lens)
    assert swing is not None
    assert np.abs(np.rad2deg(swing.angle_rad) - angles).max() < 0.02
    seen = np.array([[500.0, 100.0]])
    assert np.abs(swing.plane.to_picture(swing.plane.of_picture(seen)) - seen).max() < 1e-6


def test_points_that_share_no_pivot_give_no_error() -> None:
    """False matches alone: the fit diverges, and that is no plane instead of an OverflowError."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        frames, points = int(rng.integers(5, 12)), int(rng.integers(5, 40))
        home = rng.uniform(0.0, 400.0, (points, 2))
        seen = [home]
        for _ in range(1, frames):
            turned = (home - [200, 150]) @ turning(0.1 * rng.normal()).T + [200, 150]
            seen.append(turned + 60 * rng.normal(size=home.shape) + 20 * rng.normal(size=2))
        point, frame = np.tile(np.arange(points), frames), np.repeat(np.arange(frames), points)
        swing = calibrate_swing(Tracks(np.vstack(seen), point, frame, (300, 400)))
        assert swing is None or np.isfinite(swing.angle_rad).all()
