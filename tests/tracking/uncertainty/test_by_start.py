"""Angles that depend on where their fits start are as uncertain as that."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.calibration import CameraView
from servosight.tracking.core import STILL, MotionPlane, Shutters
from servosight.tracking.fit import AngleFit
from servosight.tracking.uncertainty import FrameMeasurements, evaluate

FRAMES, OWN_RAD = 60, 2e-4


def sigma_rad(by_start_rad: float) -> np.ndarray:
    """Of a slow swing, measured with a sigma of its own in each frame."""
    angle = 0.3 * np.sin(np.linspace(0.0, 6.0, FRAMES))
    fits: list[AngleFit | None] = [
        AngleFit(one, OWN_RAD, (0.0, 0.0), 1.0, 1.0, 0.0, 1.0, 1000) for one in angle.tolist()
    ]
    time_s = np.arange(FRAMES) / 60.0
    measured = FrameMeasurements(
        time_s.tolist(),
        [0.0] * FRAMES,
        fits,
        [STILL] * FRAMES,
        [False] * FRAMES,
        80.0,
        by_start_rad,
    )
    view = CameraView(MotionPlane(), None, "along the axis")
    found = evaluate(
        measured, time_s, view, Shutters(np.zeros(1), 0.0), learnt=10**9, correlated=False
    )
    return found.sigma_rad


def test_sigma_holds_what_the_start_changes() -> None:
    without, with_it = sigma_rad(0.0), sigma_rad(5e-3)
    assert with_it == pytest.approx(np.hypot(without, 5e-3))
