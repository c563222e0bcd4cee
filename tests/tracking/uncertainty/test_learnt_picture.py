"""The noise of the learnt picture is in all frames: more of them do not make its axis surer."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.calibration import CameraView
from servosight.tracking.core import STILL, MotionPlane, Shutters
from servosight.tracking.fit import AngleFit, PoseSensitivity
from servosight.tracking.uncertainty import EvaluatedAngles, FrameMeasurements, evaluate

FRAMES, SIGMA_PX = 400, 0.02
TURN = np.array([0.004, -0.002, 0.001, 0.006, 0.002, 0.003])  # rad/px


def evaluated(tilt_px: float, learnt: int) -> EvaluatedAngles:
    """Frames of a swing by a camera aslant, so that the picture is stretched by ``tilt_px``."""
    rng = np.random.default_rng(4)
    angle = np.deg2rad(20.0 * np.sin(np.linspace(0.0, 30.0, FRAMES)))
    weight = np.eye(6) / SIGMA_PX**2
    own = np.zeros((FRAMES, 6))
    own[:, 2] = tilt_px
    turned = own.copy()
    turned[:, 2], turned[:, 3] = tilt_px * np.cos(2.0 * angle), -tilt_px * np.sin(2.0 * angle)
    seen = own - turned + SIGMA_PX * rng.standard_normal(own.shape)
    fits: list[AngleFit | None] = [
        AngleFit(
            angle_rad=float(one),
            sigma_rad=1e-5,
            shift_px=(0.0, 0.0),
            correlation=1.0,
            kept=1.0,
            saturated=0.0,
            noise=1.0,
            pixels=1000,
            sensitivity=PoseSensitivity(weight, weight @ pose, TURN),
        )
        for one, pose in zip(angle, seen, strict=True)
    ]
    time_s = np.arange(FRAMES) / 60.0
    measured = FrameMeasurements(
        time_s.tolist(), [0.0] * FRAMES, fits, [STILL] * FRAMES, [False] * FRAMES, 80.0
    )
    view = CameraView(MotionPlane(), None, "along the axis")
    return evaluate(
        measured,
        time_s,
        view,
        Shutters(np.zeros(1), 0.0),
        learnt=learnt,
        correlated=False,
    )


def rms(found: EvaluatedAngles) -> float:
    """Of all errors that the frames share."""
    return float(np.sqrt((found.shared_rad**2).sum(1).mean()))


def test_the_shared_error_holds_the_noise_of_the_learnt_picture() -> None:
    few, many = evaluated(0.0, 25), evaluated(0.0, 10**9)
    assert rms(few) == pytest.approx(rms(many) * np.sqrt(1.0 + FRAMES / 25), rel=0.02)
    np.testing.assert_allclose(few.angle_rad, many.angle_rad)


def test_what_was_taken_for_a_tilt_is_as_unsure() -> None:
    few, many = evaluated(0.1, 25), evaluated(0.1, 10**9)
    assert few.notes == many.notes
    assert "off the axis" in few.notes[0]
    assert rms(few) > 3.5 * rms(many)
