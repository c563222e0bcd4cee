"""Repeated pictures are told by an angle that waits, and a servo's own motion is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from servosight.models.core import Array
from servosight.models.excitation import standard
from servosight.tracking.uncertainty import lag_of_repeats

SIGMA_DEG, STEP_S = 0.05, 0.0005


def servo_deg(time_s: Array, T_s: float = 0.03) -> Array:
    """A scenario's default command, steps among it, through a linear servo; with noise."""
    fine_s = np.arange(0.0, 20.0, STEP_S)
    law = signal.bilinear([1.0], [T_s**2, 1.2 * T_s, 1.0], 1.0 / STEP_S)
    angle = signal.lfilter(*law, standard(20.0, 20.0, 0).at(fine_s))
    noise = SIGMA_DEG * np.random.default_rng(5).standard_normal(time_s.size)
    return np.asarray(np.interp(time_s, fine_s, angle) + 0.3 * noise)


@pytest.mark.parametrize("rate_hz", [24.0, 30.0, 60.0, 120.0, 240.0])
@pytest.mark.parametrize("T_s", [0.02, 0.04])
def test_a_servo_s_own_motion_is_no_repeat(rate_hz: float, T_s: float) -> None:
    angle = servo_deg(np.arange(0.0, 19.0, 1.0 / rate_hz), T_s)
    assert np.count_nonzero(lag_of_repeats(angle, np.full(angle.size, SIGMA_DEG))) == 0


@pytest.mark.parametrize("every", [5, 7])
def test_repeated_pictures_lag_by_what_the_part_turned(every: int) -> None:
    """Truth: the angles of the frames' own times, from slow sines to steps and a fast chirp.

    Of the frames that lag by more than five sigma, a fifth may not be recognised (17 % of those
    with each seventh repeated): where the chirp is too fast for the frame rate. No other frame is
    taken for one. Where they are recognised the lag is right to a fifth of a step.
    """
    true = servo_deg(np.arange(0.0, 15.0, 1.0 / 60.0))
    number = np.arange(true.size)
    shown = number - (number % every == every - 1)
    behind = true - true[shown]
    found = lag_of_repeats(true[shown], np.full(true.size, SIGMA_DEG))
    late = np.abs(behind) > 5.0 * SIGMA_DEG
    assert np.count_nonzero(late) > 40
    assert np.mean(found[late] == 0.0) < 0.2
    assert not found[behind == 0.0].any()
    known = late & (found != 0.0)
    step = np.abs(np.gradient(true))
    assert np.quantile(np.abs(found - behind)[known] / step[known], 0.95) < 0.2


def test_what_is_not_known_is_no_repeat() -> None:
    angle = np.array([np.nan, 1.0, 2.0, 2.0, 4.0, np.nan, np.nan])
    assert not lag_of_repeats(angle, np.full(7, 0.1)).any()  # too few about it
    assert not lag_of_repeats(np.full(6, np.nan), np.full(6, 0.1)).any()
    assert lag_of_repeats(np.zeros(3), np.full(3, 0.1)).size == 3
