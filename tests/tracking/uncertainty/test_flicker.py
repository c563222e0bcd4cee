"""A flickering lamp's course from the gain of frames, against its integral over each exposure."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.uncertainty._flicker import light_centre

FRAMES = np.arange(240)
EXPOSURE_S = 0.002


def lamp(time_s: np.ndarray, hertz: float, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Gain, and how late the middle of the light comes [s], by sums over each exposure."""
    part = ((np.arange(400) + 0.5) / 400 - 0.5) * EXPOSURE_S
    light = 1.0 - 0.2 * time_s[:, None]
    light = light * (1.0 + share * np.sin(2 * np.pi * hertz * (time_s[:, None] + part) + 0.3))
    return light.mean(1), (light * part).mean(1) / light.mean(1)


@pytest.mark.parametrize(("hertz", "rate_hz"), [(100.0, 119.3), (120.0, 90.0)])
def test_the_middle_of_the_light(hertz: float, rate_hz: float) -> None:
    """Within a twentieth: the slow fade bends the fit of the wave."""
    time_s = FRAMES / rate_hz
    gain, late_s = lamp(time_s, hertz, 0.2)
    found_s, sigma_s = light_centre(time_s, gain, EXPOSURE_S)
    assert np.abs(found_s - late_s).max() < 0.05 * np.abs(late_s).max()
    assert (sigma_s < 0.05 * np.abs(late_s).max()).all()


def test_a_steady_lamp_and_noise_move_nothing() -> None:
    gain = 1.0 + 0.001 * np.random.default_rng(1).standard_normal(FRAMES.size)
    for found in (gain, np.full_like(gain, np.nan)):
        assert not np.any(light_centre(FRAMES / 120.0, found, EXPOSURE_S))
