"""Controllers that integrate, up to a limit or without, where the answer is known otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from support.plants import plant

from servosight.models.core import Array
from servosight.models.plant import Stimulus

T, XI = 0.02, 0.6


def simulated(
    time_s: Array, command_deg: Array, start_deg: float = 0.0, speed: float = 0.0, **values: float
) -> Array:
    """Angles at the command's own times, lines between its rows; ``integral_action__rate=3``."""
    row = np.array(plant().layout.neutral_row())
    row[:6] = 1.0, T, XI, 0.0, start_deg, speed
    for name, value in values.items():
        row[plant().index(name.replace("__", "."))] = value
    return plant().simulate(row, Stimulus(time_s, command_deg, True, time_s, np.ones(1)))


@pytest.mark.parametrize("lag", [0.0, 0.03])
def test_a_ramp_is_followed_with_the_lag_of_the_integral(lag: float) -> None:
    """Truth: at constant speed the integral no longer changes, so the error is lag times speed."""
    time_s = np.arange(0.0, 3.0, 0.002)
    ramp = 40.0 * time_s
    angle = simulated(time_s, ramp, integral_action__rate=8.0, integral_action__lag=lag)
    late = (ramp - angle)[time_s > 2.0] / 40.0
    np.testing.assert_allclose(late, lag, atol=1e-5)
    plain = simulated(time_s, ramp)
    np.testing.assert_allclose((ramp - plain)[-1] / 40.0, 2.0 * XI * T, atol=1e-5)


def test_a_weight_is_held_where_the_command_is_from_the_first_instant() -> None:
    """Truth: who has long stood under a weight of 9 deg stands at the command, and goes on to."""
    time_s = np.arange(0.0, 1.0, 0.01)
    held = {"gravity_load__cosine": 9.0, "integral_action__rate": 20.0}
    angle = simulated(time_s, np.zeros_like(time_s), **held)
    np.testing.assert_allclose(angle, 0.0, atol=1e-6)


def test_of_a_weight_above_its_limit_the_rest_stays() -> None:
    """Truth: of a weight of 9 deg the integral holds 4; the loop hangs 5 deg below the command."""
    time_s = np.arange(0.0, 2.0, 0.01)
    held = {"limited_integral__rate": 20.0, "limited_integral__limit": 4.0}
    angle = simulated(time_s, np.zeros_like(time_s), gravity_load__cosine=9.0, **held)
    missing = angle[-1] + 9.0 * np.cos(np.deg2rad(angle[-1]))
    np.testing.assert_allclose(missing, 4.0, atol=1e-6)


def test_a_limit_is_left_as_soon_as_the_error_turns_round() -> None:
    """Truth: friction of 10 deg holds the motor under an error of 2 deg, of which the integral
    gathers 20 deg/s: 8 deg after 0.4 s, but for a limit of 1 deg. An error of -10 deg takes that
    back at 100 deg/s, so that the torque passes -10 deg after 0.01 s."""
    time_s = np.arange(-1.0, 6.0, 0.005)
    goal = np.where(time_s < 0.0, 0.0, np.where(time_s < 4.0, 2.0, -10.0))
    stuck = {"coulomb_friction__level": 10.0, "limited_integral__rate": 10.0}
    free = simulated(time_s, goal, **stuck)
    assert np.all(free[time_s < 0.4] == 0.0)
    assert np.all(free[(time_s > 0.45) & (time_s < 1.0)] > 0.0)
    limited = simulated(time_s, goal, limited_integral__limit=1.0, **stuck)
    assert np.all(limited[time_s < 4.0] == 0.0)
    assert 4.0 < time_s[np.flatnonzero(limited)[0]] <= 4.02


def test_without_a_rate_nothing_is_held() -> None:
    """Truth: the weight pulls the loop without an integral to its own rest, below -8 deg."""
    time_s = np.arange(0.0, 2.0, 0.01)
    weight = {"gravity_load__cosine": 9.0}
    plain = simulated(time_s, np.zeros_like(time_s), **weight)
    slow = simulated(time_s, np.zeros_like(time_s), integral_action__rate=1e-6, **weight)
    assert plain[-1] < -8.0
    np.testing.assert_allclose(slow, plain, atol=1e-4)


def test_what_friction_leaves_of_an_error_dies_away() -> None:
    """Truth: a step within the friction leaves the loop where it is, until the integral has it."""
    time_s = np.arange(-1.0, 4.0, 0.005)
    goal = np.where(time_s < 0.0, 0.0, 0.5)
    stays = simulated(time_s, goal, coulomb_friction__level=1.0)
    comes = simulated(time_s, goal, coulomb_friction__level=1.0, integral_action__rate=5.0)
    np.testing.assert_allclose(stays, 0.0, atol=1e-9)
    # 0.5 deg and what it has gathered exceed the friction of 1 deg after 0.2 s.
    assert np.all(comes[time_s < 0.19] == 0.0)
    assert np.all(comes[time_s > 0.25] > 0.0)
