"""Frame times, exposure and the instants that sample it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Camera, exposure_nodes


@pytest.mark.parametrize("rate_hz", [29.97, 120.0, 240.0])
def test_frames_end_within_the_duration(rate_hz: float) -> None:
    camera = Camera(rate_hz=rate_hz, exposure_s=0.002)
    starts = camera.frame_starts(2.0, 0.5)
    np.testing.assert_allclose(np.diff(starts), 1 / rate_hz)
    assert starts[0] == 0.5
    assert starts[-1] + camera.exposure_s <= 2.5 + 1e-9
    assert starts[-1] + camera.exposure_s + 1 / rate_hz > 2.5


def test_a_frame_that_just_fits_is_kept() -> None:
    assert Camera(rate_hz=10.0).frame_starts(1.0).size == 11
    assert Camera(rate_hz=10.0, exposure_s=0.1).frame_starts(1.0).size == 10
    assert Camera(rate_hz=10.0, exposure_s=0.1).frame_starts(0.05).size == 0


def test_jitter_and_lost_frames_are_seeded() -> None:
    camera = Camera(rate_hz=100.0, exposure_s=0.002, jitter_s=5e-4, dropped=0.2, clock_seed=3)
    starts = camera.frame_starts(20.0, 1.0)
    assert np.array_equal(starts, camera.frame_starts(20.0, 1.0))
    assert starts[0] == 1.0
    assert starts.size == pytest.approx(1600, abs=4 * np.sqrt(2000 * 0.2 * 0.8))
    late = starts - 1.0 - np.round((starts - 1.0) * 100.0) / 100.0
    # Cutting a Gaussian at three sigma takes 1.3 % of its rms; 1600 samples scatter by 1.8 %.
    assert late.std() == pytest.approx(5e-4, rel=0.07)
    assert np.abs(late).max() <= 1.5e-3 + 1e-12
    assert np.all(np.diff(starts) > 0.005)


def test_mid_exposure_is_the_middle_rows() -> None:
    """Half the exposure after the start, and half the readout later for the middle row."""
    camera = Camera(exposure_s=0.004, readout_s=0.010)
    np.testing.assert_allclose(camera.mid_exposure(np.array([1.0])), [1.007])


def test_without_exposure_one_instant() -> None:
    nodes, weights = exposure_nodes(np.array([0.1, 0.2]), 0.0)
    np.testing.assert_array_equal(nodes, [0.1, 0.2])
    np.testing.assert_array_equal(weights, [1.0])


def test_nodes_average_polynomials_of_ninth_degree_exactly() -> None:
    """Truth: the mean of t^9 over an exposure, by hand."""
    middle, exposure = np.array([0.5, 1.0]), 0.4
    nodes, weights = exposure_nodes(middle, exposure)
    assert weights.sum() == pytest.approx(1.0)
    assert np.all(np.diff(nodes) > 0.0)
    low, high = middle - exposure / 2, middle + exposure / 2
    truth = (high**10 - low**10) / (10 * exposure)
    np.testing.assert_allclose((nodes**9).reshape(2, -1) @ weights, truth, rtol=1e-13)
