"""The bound beside which docs/measured/video.md sets the tracker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from filmed.bound import bound_deg
from servosight.models.core import Camera
from servosight.sim.film import VideoSettings

CAMERA = Camera(exposure_s=0.002)


def bound(gain: float, pixel_offset_rms: float) -> float:
    """At rest [deg], with this noise of the sensor."""
    usual = VideoSettings()
    optics = replace(usual.optics, gain=gain, pixel_gain_rms=0.0, pixel_offset_rms=pixel_offset_rms)
    settings = replace(usual, optics=optics)
    return float(bound_deg(CAMERA, settings, np.array([3.0]), np.zeros(1))[0])


def test_the_bound_follows_the_noise_of_the_pixels() -> None:
    """Without shot noise the variance is that of quantization and offset alone."""
    ratio = bound(0.0, 1.0) / bound(0.0, 0.5)
    assert ratio == pytest.approx(np.sqrt((1.0 + 1.0 / 12.0) / (0.25 + 1.0 / 12.0)), rel=1e-6)


def test_shot_noise_of_two_grey_levels_counts_more_than_quantization() -> None:
    """Quantization alone is 0.29 grey levels: seven times less in a picture of medium grey."""
    usual = VideoSettings().optics.gain
    assert 3.0 < bound(usual, 0.0) / bound(0.0, 0.0) < 12.0
