"""Drives with a PI speed loop: their simulation, and what a diagnosis of one leaves open."""

from __future__ import annotations

from dataclasses import astuple, replace

import numpy as np
import pytest

from cascade import KEPT, STEP_S, Drive, line, march, moves, recordings, sines
from servosight.diagnose import diagnose

PLAIN = Drive(
    position_gain=8.0,
    speed_gain=80.0,
    integral_s=0.04,
    forward=0.0,
    period_s=2.5e-4,
    limit=1e9,
    level=1e-9,
    excess=0.0,
    speed=5.0,
    viscous=2.0,
    weight=0.0,
)


@pytest.mark.parametrize(("forward", "lag_s"), [(0.0, 1.0 / 8.0), (0.8, 0.2 / 8.0), (1.0, 0.0)])
def test_a_ramp_is_followed_with_what_the_position_loop_alone_leaves(
    forward: float, lag_s: float
) -> None:
    """Truth: the integral takes the speed's error away, so kp lag + forward = 1."""
    rows_s = np.arange(0.0, 3.0, 1e-3)
    ramp = 30.0 * rows_s
    drive = replace(PLAIN, forward=forward, weight=500.0)
    angle = march(astuple(drive), ramp, np.full_like(ramp, 30.0), 1e-3, round(3.0 / STEP_S))
    time_s = KEPT * STEP_S * np.arange(angle.size)
    late_s = (30.0 * time_s - angle)[time_s > 2.0] / 30.0
    # A weight that changes by 9 deg/s^2 in a second asks for a little more; a row is 1 ms late.
    np.testing.assert_allclose(late_s, lag_s, atol=3e-3)


def test_play_that_stands_in_for_friction_within_the_tolerance_is_left_open() -> None:
    """The model with the effects that are there errs clearly less, and both are listed."""
    drive, halves = recordings(23)
    fitted, chosen, tested = next(halves)
    found = diagnose([fitted], validate=[chosen], test=[tested], auto=True)
    assert (found.verdict.value, found.effects) == ("explained", ())
    assert found.one_of == {"feedback_backlash": ("integral_action", "coulomb_friction")}
    assert "errs clearly less" in found.summary
    row = line(23, 1, drive, found, 7.0)
    assert row.startswith("| 23.1 | torque_saturation | - | no | - |")


def test_commands_begin_at_rest() -> None:
    time_s = np.arange(0.0, 10.0, 1e-3)
    for shape in (sines, moves):
        command = shape(np.random.default_rng(1), time_s)
        assert abs(command[0]) < 1e-9
        assert np.abs(command[10]) < 0.01
        assert np.ptp(command) > 15.0
