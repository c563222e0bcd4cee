"""Which of two parts drives the other, where play between them shows it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.sim.linkage import Linkage
from servosight.tracking.linkage._order import drives, lag_deg, move_as_one

TIME_S = np.arange(0.0, 4.0, 0.01)
SHAPE = Linkage(16.0, 20.0, 20.0)


def driver_deg() -> Array:
    return np.asarray(14 * np.sin(2 * np.pi * 0.9 * TIME_S) + 7 * np.sin(2 * np.pi * 2.3 * TIME_S))


def driven_deg(driver: Array, gap: float) -> Array:
    """Behind play of full width ``gap`` and a four-bar linkage."""
    place = np.empty(driver.size)
    held = driver[0]
    for n, angle in enumerate(driver):
        held = min(max(held, angle - gap / 2), angle + gap / 2)
        place[n] = held
    return SHAPE.surface_deg(place)


@pytest.mark.parametrize("gap", [0.1, 0.8])
@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_the_part_that_moves_on_is_the_driver(gap: float, turn: float) -> None:
    """Whatever the linkage between the two is, and also where it turns the other way."""
    rng = np.random.default_rng(1)
    noise = 0.005 * rng.standard_normal((2, TIME_S.size))
    driver = driver_deg() + noise[0]
    driven = turn * driven_deg(driver_deg(), gap) + noise[1]
    assert drives(driver, driven, 0.005) is True
    assert drives(driven, driver, 0.005) is False


@pytest.mark.parametrize("seed", range(5))
def test_without_play_neither_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = 0.005 * rng.standard_normal((2, TIME_S.size))
    driver, driven = driver_deg() + noise[0], driven_deg(driver_deg(), 0.0) + noise[1]
    assert drives(driver, driven, 0.005) is None


def test_a_delay_is_no_play() -> None:
    """The rows of a rolling shutter see the two parts at different times: here by 3 ms."""
    later = np.interp(TIME_S - 0.003, TIME_S, driver_deg())
    assert drives(driver_deg(), SHAPE.surface_deg(later), 0.02) is None


def test_what_rests_tells_nothing() -> None:
    assert np.isnan(lag_deg(np.zeros(400), driver_deg())[0])
    assert drives(np.zeros(400), driver_deg(), 0.005) is None
    assert drives(driver_deg()[:20], driver_deg()[:20], 0.005) is None


def test_two_servos_are_no_linkage() -> None:
    """Each with a motion of its own; nor is a servo and what rests."""
    rng = np.random.default_rng(1)
    driven = driven_deg(driver_deg(), 0.8) + 0.005 * rng.standard_normal(TIME_S.size)
    other = 12 * np.sin(2 * np.pi * 0.7 * TIME_S + 1.0) + 6 * np.sin(2 * np.pi * 1.9 * TIME_S)
    assert move_as_one(driven, driver_deg())
    assert move_as_one(driver_deg(), driven)
    assert not move_as_one(driven, other)
    assert not move_as_one(driven, np.zeros(TIME_S.size))
