"""Trajectories as a camera sees them."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Camera
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.run import angle_recording, steps_between, zero_order_hold


def spinning(rate_hz: float = 3.0, duration_s: float = 2.0) -> Trajectory:
    """20 deg sine on the twin's grid."""
    time_s = np.arange(int(duration_s * 1e4) + 1) / 1e4
    angle = 20.0 * np.sin(2 * np.pi * rate_hz * time_s)
    command = Excitation(np.array([0.0, duration_s]), np.array([0.0, 1.0]))
    return Trajectory(time_s, angle, angle, np.zeros_like(angle), command)


def test_angle_between_grid_points() -> None:
    """Bound: a h^2 / 8 of the sine's largest acceleration."""
    time_s = np.linspace(0.0, 2.0, 777)
    error = spinning().angle_at(time_s) - 20.0 * np.sin(6 * np.pi * time_s)
    assert np.abs(error).max() < 20.0 * (6 * np.pi) ** 2 * 1e-8 / 8 * 1.01


def test_mean_over_the_exposure_is_the_integral() -> None:
    mid, exposure, omega = np.linspace(0.1, 1.9, 301), 0.0083, 6 * np.pi
    exact = 20.0 * np.sin(omega * mid) * np.sinc(omega * exposure / 2 / np.pi)
    np.testing.assert_allclose(spinning().mean_angle(mid, exposure), exact, atol=2e-5)
    np.testing.assert_array_equal(spinning().mean_angle(mid, 0.0), spinning().angle_at(mid))


def test_recording_has_mid_exposure_times_noise_and_the_senders_rows() -> None:
    trajectory = spinning(duration_s=20.0)
    camera = Camera(rate_hz=120.0, exposure_s=0.004)
    recording = angle_recording(trajectory, camera, 0.03, seed=5)
    clean = trajectory.mean_angle(recording.time_s, 0.004)
    assert recording.time_s[0] == pytest.approx(0.002)
    assert recording.time_s[-1] + 0.002 <= 20.0 + 1e-9
    # 2400 samples: the estimate of sigma scatters by 1 / sqrt(4800), 1.4 %; bound: 4 of these.
    assert np.std(recording.angle_deg - clean) == pytest.approx(0.03, rel=0.06)
    assert recording.sigma_deg is not None
    assert set(recording.sigma_deg) == {0.03}
    assert recording.exposure_s == 0.004
    np.testing.assert_array_equal(recording.command_deg, [0.0, 1.0])

    again = angle_recording(trajectory, camera, 0.03, seed=5, with_sigma=False)
    np.testing.assert_array_equal(again.angle_deg, recording.angle_deg)
    assert again.sigma_deg is None


def test_steps_have_every_knot_among_their_edges() -> None:
    knots = np.array([-1.0, 0.25, 0.25, 1.0, 1.0 + 1e-9, 2.5])
    edges = steps_between(0.0, knots, 2.0, 0.5)
    np.testing.assert_allclose(edges, [0.0, 0.25, 0.625, 1.0, 1.5, 2.0], atol=1e-8)


def test_a_held_command_jumps_at_its_rows() -> None:
    time_s, value = zero_order_hold(
        Excitation(np.array([0.0, 0.25, 2.5]), np.array([0.0, 4.0, 8.0]))
    )
    np.testing.assert_array_equal(time_s, [0.0, 0.25, 0.25, 2.5, 2.5])
    np.testing.assert_array_equal(value, [0.0, 0.0, 4.0, 4.0, 8.0])
