"""What cannot be seen of the shutter is said, and widens sigma."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.tracking.calibration.shutter._find import best_shutter
from servosight.tracking.core import Shutter, TrackOptions
from servosight.tracking.track import track

SLOW_DEG = 4.0 * np.sin(2 * np.pi * np.arange(60) / 240.0)


def test_a_slow_surface_does_not_tell_the_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    """0.1 deg a frame, 0.4 px at the tip. A shutter may roll for up to a frame time, which moves
    what lies off the middle row by up to half of that."""
    video = drawn("slow", scene(SLOW_DEG))
    given = track(video, TrackOptions(exposure_s=0.0))
    not_given = track(video)
    assert any("not given" in note for note in not_given.notes)
    assert not any("not given" in note for note in given.notes)
    np.testing.assert_allclose(not_given.angle_deg, given.angle_deg, atol=0.005)
    assert np.all(not_given.sigma_deg >= 0.99 * given.sigma_deg)
    assert np.max(not_given.sigma_deg**2 - given.sigma_deg**2) < (0.1 * 0.5) ** 2


def test_template_matching_knows_no_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    matched = track(drawn("slow", scene(SLOW_DEG)), TrackOptions(method="match"))
    assert not any("not given" in note for note in matched.notes)


@pytest.mark.parametrize(
    ("exposure_s", "readout_s"), [(0.0078, 0.0), (0.001, 0.0075), (0.004, -0.006)]
)
def test_a_wrong_exposure_may_pass_for_a_readout(exposure_s: float, readout_s: float) -> None:
    """A bent valley: without the exposure the readout looks 3 ms off, beyond the finer steps about
    it. Noise of 0.1 % in 24 frames leaves a few microseconds; a fine step is 0.35 ms."""
    rng = np.random.default_rng(1)
    noise = 1.0 + 0.001 * rng.standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        opens = (shutter.exposure_s - exposure_s) / 0.002
        rolls = (shutter.readout_s - readout_s) / 0.002 - 0.4 * opens
        return noise + opens**2 + 0.5 * rolls**2

    found = best_shutter(left, 1.0 / 120.0, left)

    assert found.shutter.exposure_s == pytest.approx(exposure_s, abs=1e-4)
    assert found.shutter.readout_s == pytest.approx(readout_s, abs=1e-4)


def test_a_valley_without_a_lowest_place_tells_nothing() -> None:
    """Each round leads 2 ms farther. Where it ends at the edge of the steps tried, no frame's
    removal changes anything: without scatter sigma would be zero."""

    def left(shutter: Shutter) -> np.ndarray:
        apart = (shutter.exposure_s - shutter.readout_s) / 0.001
        return np.full(24, 200.0 + apart**2 - 2.0 * shutter.exposure_s / 0.0005)

    frame_s = 1.0 / 30.0
    found = best_shutter(left, frame_s, left)
    assert found.exposure_doubt_s > 0.2 * frame_s
    assert found.readout_doubt_s > 0.2 * frame_s
