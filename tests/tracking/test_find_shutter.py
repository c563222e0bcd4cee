"""What cannot be seen of the shutter is said, and widens sigma."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from servosight.tracking.track import track

SLOW_DEG = 4.0 * np.sin(2 * np.pi * np.arange(60) / 240.0)


def test_a_slow_surface_does_not_tell_the_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    """0.1 deg a frame, 0.4 px at the tip. A shutter may roll for up to a frame time, which moves
    what lies off the middle row by up to half of that."""
    video = drawn("slow", scene(SLOW_DEG))
    told = track(video, exposure_s=0.0)
    untold = track(video)
    assert any("not told" in note for note in untold.notes)
    assert not any("not told" in note for note in told.notes)
    np.testing.assert_allclose(untold.angle_deg, told.angle_deg, atol=0.005)
    assert np.all(untold.sigma_deg >= 0.99 * told.sigma_deg)
    assert np.max(untold.sigma_deg**2 - told.sigma_deg**2) < (0.1 * 0.5) ** 2


def test_template_matching_knows_no_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    matched = track(drawn("slow", scene(SLOW_DEG)), method="match")
    assert not any("not told" in note for note in matched.notes)
