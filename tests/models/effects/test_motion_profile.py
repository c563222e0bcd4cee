"""The trapezoid of a firmware's profile against distances and times by hand."""

from __future__ import annotations

import math

import pytest

from servosight.models.effects.builtin.motion_profile import term

RATE, ACCELERATION = 100.0, 1000.0


def follow(
    goal: float,
    end_s: float,
    *,
    at: float = 0.0,
    speed: float = 0.0,
    slope: float = 0.0,
    limits: tuple[float, float] = (RATE, ACCELERATION),
) -> tuple[float, float, int]:
    """Angle and speed after ``end_s`` behind a goal on a line, and how many pieces it took."""
    time_s, pieces = 0.0, 0
    while time_s < end_s - 1e-12:
        value = goal + slope * time_s
        at, chord, horizon, change = term(value, slope, end_s - time_s, at, speed, *limits)
        at += chord * horizon
        speed += change * horizon
        time_s += horizon
        pieces += 1
    return at, speed, pieces


@pytest.mark.parametrize(
    ("time_s", "angle", "speed"),
    [
        (0.05, 1.25, 50.0),  # a t^2 / 2
        (0.1, 5.0, 100.0),  # at full speed
        (0.3, 25.0, 100.0),
        (0.35, 28.75, 50.0),  # 30 - a (0.4 - t)^2 / 2
        (0.4, 30.0, 0.0),
        (2.0, 30.0, 0.0),
    ],
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_step_that_reaches_the_speed(
    time_s: float, angle: float, speed: float, way: float
) -> None:
    at, now, _ = follow(30.0 * way, time_s)
    assert at == pytest.approx(way * angle, abs=1e-6)
    assert now == pytest.approx(way * speed, abs=1e-4)


def test_a_short_step_takes_the_root_of_its_size() -> None:
    for size in (0.4, 1.6):
        lasts = 2.0 * math.sqrt(size / ACCELERATION)
        assert follow(size, 0.5 * lasts)[0] == pytest.approx(0.5 * size, abs=1e-6)
        assert follow(size, lasts)[:2] == pytest.approx((size, 0.0), abs=1e-3)


def test_too_fast_to_stop_it_overshoots_and_comes_back() -> None:
    """From 80 deg/s it stops 3.2 deg on; from there it takes 2 sqrt(2.2 / a) back to 1 deg."""
    assert follow(1.0, 0.08, speed=80.0)[:2] == pytest.approx((3.2, 0.0), abs=1e-3)
    back = 0.08 + 2.0 * math.sqrt(2.2 / ACCELERATION)
    assert follow(1.0, back, speed=80.0)[0] == pytest.approx(1.0, abs=1e-4)


def test_it_ends_on_a_goal_that_moves_and_lags_one_that_is_too_fast() -> None:
    at, speed, _ = follow(0.0, 1.0, slope=40.0)
    assert (at, speed) == pytest.approx((40.0, 40.0), abs=1e-3)
    assert follow(0.0, 1.0, slope=300.0)[0] == pytest.approx(100.0 - 5.0, abs=1e-3)


def test_without_a_limit_of_the_acceleration_it_is_a_rate_limit() -> None:
    at, _, pieces = follow(30.0, 0.2, limits=(RATE, math.inf))
    assert (at, pieces) == pytest.approx((20.0, 1))
    assert follow(30.0, 0.5, limits=(RATE, math.inf))[0] == pytest.approx(30.0)


def test_without_a_limit_of_the_speed_it_accelerates_half_way() -> None:
    lasts = 2.0 * math.sqrt(90.0 / ACCELERATION)
    at, speed, _ = follow(90.0, 0.5 * lasts, limits=(math.inf, ACCELERATION))
    assert (at, speed) == pytest.approx((45.0, math.sqrt(90.0 * ACCELERATION)), abs=1e-3)


@pytest.mark.parametrize("rate", [3.0, 21.7, math.inf])
@pytest.mark.parametrize("acceleration", [2400.0, 1e6, 1e11])
def test_a_goal_that_runs_past_faster_than_the_rate_is_not_followed(
    rate: float, acceleration: float
) -> None:
    """It comes from behind at 267 deg/s; the speed stays within the limit, the pieces few."""
    at, speed, pieces = follow(-2.0, 0.05, slope=267.0, limits=(rate, acceleration))
    assert abs(speed) <= min(rate, 267.0) * (1.0 + 1e-6)
    assert pieces < 2000
    assert at <= -2.0 + 267.0 * 0.05 + 1e-6
