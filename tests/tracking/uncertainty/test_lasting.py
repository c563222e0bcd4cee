"""Errors that neighbouring frames share are seen; motion is not taken for them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from servosight.models.core import Array
from servosight.tracking.uncertainty._lasting import lasting, with_scatter
from servosight.tracking.uncertainty._scatter import scatter

FRAMES = 600
SIZE_DEG = 0.02


def errors_deg(shared: float) -> Array:
    """Errors of 0.02 deg, of which a frame keeps that share of the frame before."""
    rng = np.random.default_rng(12)
    error = rng.standard_normal(FRAMES)
    for number in range(1, FRAMES):
        error[number] = shared * error[number - 1] + np.sqrt(1 - shared**2) * error[number]
    return np.asarray(SIZE_DEG * error)


@pytest.mark.parametrize("shared", [0.0, 0.3, 0.6])
def test_sigma_holds_errors_that_last(shared: float) -> None:
    """The scatter of neighbours alone is 0.7 and 0.5 of the last two."""
    angle = 10.0 * np.sin(np.arange(FRAMES) / 12.0) + errors_deg(shared)
    sigma = lasting(angle) * np.sqrt(np.mean(scatter(angle) ** 2))
    assert sigma == pytest.approx(SIZE_DEG, rel=0.15)


@pytest.mark.parametrize("per_frame", [0.02, 0.05, 0.1, 0.2, 0.3, 0.4])
@pytest.mark.parametrize("amplitude_deg", [1.0, 30.0])
def test_an_oscillation_is_no_error(per_frame: float, amplitude_deg: float) -> None:
    course = amplitude_deg * np.sin(2 * np.pi * per_frame * np.arange(FRAMES))
    assert lasting(course + errors_deg(0.0)) < 1.3


@pytest.mark.parametrize("apart", [8, 15, 30, 60])
def test_steps_are_no_error(apart: int) -> None:
    """Steps of 20 deg within some four frames: a thousand times the errors."""
    level = np.random.default_rng(3).choice([-10.0, 10.0], FRAMES // apart + 1)
    course = ndimage.gaussian_filter1d(np.repeat(level, apart)[:FRAMES], 1.5)
    assert lasting(course + errors_deg(0.0)) < 2.0


def test_few_frames_tell_nothing() -> None:
    assert lasting(errors_deg(0.6)[:30]) == 1.0
    assert lasting(np.zeros(FRAMES)) == 1.0


def test_smooth_errors_are_seen_although_they_decrease_with_the_order() -> None:
    """Errors of 0.02 deg that a codec corrects within some two frames: 0.004 deg of scatter. What
    lasts of them counts up to 4.5 times that: more may be motion."""
    error = ndimage.gaussian_filter1d(errors_deg(0.0), 0.82)
    error *= SIZE_DEG / error.std()
    angle = 10.0 * np.sin(np.arange(FRAMES) / 16.0) + error
    usual = np.sqrt(np.mean(scatter(angle) ** 2))
    assert usual < 0.3 * SIZE_DEG
    assert 0.75 * SIZE_DEG < lasting(angle) * usual < 1.5 * SIZE_DEG


def test_what_the_residuals_show_of_such_errors_does_not_count_twice() -> None:
    angle = 10.0 * np.sin(np.arange(FRAMES) / 12.0) + errors_deg(0.6)
    unseen, seen = (with_scatter(np.full(FRAMES, own), angle) for own in (0.0, SIZE_DEG))
    assert np.sqrt(np.mean(unseen**2)) == pytest.approx(SIZE_DEG, rel=0.15)
    assert seen == pytest.approx(np.hypot(SIZE_DEG, scatter(angle)))
