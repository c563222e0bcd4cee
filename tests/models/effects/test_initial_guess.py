"""Initial guesses from residuals."""

from __future__ import annotations

import numpy as np

from servosight.models.effects import ResidualFeatures
from servosight.models.effects._initial_guess import quantization_steps


def test_an_angle_that_does_not_follow_has_no_quantization_step() -> None:
    """A fit without gain: no step of the command shows in the angle."""
    command_deg = np.repeat([0.0, 1e-6], 30)
    away = np.repeat([0.0, 5.0], 30)
    curves = ResidualFeatures(command_deg, away, 0.0 * away, 0.0 * away, away, 1 / 120, 0.0)
    assert quantization_steps(curves, 1.0) == ()
