"""The first guess of a recording's own numbers, on recordings that show them."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.identify.problem import own_start, own_starts
from servosight.models.core import Recording

TIME_S = np.arange(200) / 50.0
ANGLES_DEG = np.array([4.0, 5.0, 7.5, 100.0])
"""The first angles; their mean is 5.5 of three, 29.1 of four."""


@pytest.mark.parametrize(("gain", "bias_deg"), [(0.8, 3.0), (1.0, -2.0), (-0.5, 1.5)])
def test_the_bias_is_what_the_gain_leaves_of_the_angle(gain: float, bias_deg: float) -> None:
    """Held at 12 deg all the time; and with a quarter of outliers, as it is a median."""
    command = np.full(200, 12.0)
    angle = gain * command + bias_deg
    angle[150:] += 40.0
    found = own_start(Recording("held", TIME_S, command, TIME_S, angle), gain)
    assert found[0] == pytest.approx(bias_deg, abs=1e-12)


def test_the_motion_begins_at_the_mean_of_three_samples_and_at_rest() -> None:
    angle = np.concatenate([ANGLES_DEG, np.full(196, 8.0)])
    found = own_start(Recording("run", TIME_S, np.sin(TIME_S), TIME_S, angle), 1.0)
    assert found[1:].tolist() == [5.5, 0.0]


def test_only_samples_under_the_mask_count() -> None:
    command = np.full(200, 12.0)
    angle = np.where(TIME_S < 3.0, 50.0, 10.0)
    recording = Recording("run", TIME_S, command, TIME_S, angle)
    assert own_start(recording, 1.0, TIME_S >= 3.0).tolist() == [-2.0, 10.0, 0.0]
    assert own_start(recording, 1.0).tolist() == [38.0, 50.0, 0.0]


def test_other_guesses_have_the_bias_of_the_first_samples_and_none() -> None:
    """At rest at 12 deg for a command of 10, then kept far from one of 60; the mask counts."""
    command = np.where(TIME_S < 1.0, 10.0, 60.0)
    angle = np.where(TIME_S < 1.0, 12.0, 20.0)
    recording = Recording("loaded", TIME_S, command, TIME_S, angle)
    assert own_starts(recording, 1.0)[:, 0].tolist() == [-40.0, 2.0, 0.0]
    assert own_starts(recording, 1.0, TIME_S >= 2.0)[:, 0].tolist() == [-40.0, -40.0, 0.0]
    assert own_starts(recording, 1.0)[:, 1:].tolist() == [[12.0, 0.0]] * 3
