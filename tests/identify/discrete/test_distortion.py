"""Even and odd distortion from an odd multisine, without any model of the servo."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from servosight.identify.discrete import distortion
from servosight.models.core import Array, InputError, Recording
from servosight.models.excitation import CommandLimits, Excitation, design

NOISE_DEG = 0.02
T, XI = 0.03, 0.7


def answer(excitation: Excitation, load: Callable[[float], float]) -> Array:
    """T^2 y'' + 2 xi T y' + y + load(y) = u on the rows, Runge and Kutta's fourth order."""

    def slope(y: float, w: float, u: float) -> tuple[float, float]:
        return w, (u - y - load(y) - 2.0 * XI * T * w) / T**2

    h = 1.0 / 250.0 / 4.0
    y = w = 0.0
    found = []
    for u in excitation.command_deg.tolist():
        found.append(y)
        for _ in range(4):
            a1, b1 = slope(y, w, u)
            a2, b2 = slope(y + 0.5 * h * a1, w + 0.5 * h * b1, u)
            a3, b3 = slope(y + 0.5 * h * a2, w + 0.5 * h * b2, u)
            a4, b4 = slope(y + h * a3, w + h * b3, u)
            y += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            w += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    return np.array(found)


EXCITATION = design("multisine", CommandLimits(15.0, None, 12.0), seed=1).excitation


def recorded(angle_deg: Array, seed: int, rate_hz: float = 125.0) -> Recording:
    """Frames at ``rate_hz``, that need not fit the rows or the period, with white noise."""
    time_s = np.arange(0.0, 12.0, 1.0 / rate_hz)
    exact = np.interp(time_s, EXCITATION.time_s, angle_deg)
    if rate_hz != 125.0:  # between rows the angle is no straight line
        exact = _smooth(time_s, angle_deg)
    noise = np.random.default_rng(seed).normal(0.0, NOISE_DEG, time_s.size)
    return Recording("made", EXCITATION.time_s, EXCITATION.command_deg, time_s, exact + noise)


def _smooth(time_s: Array, angle_deg: Array) -> Array:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(EXCITATION.time_s, angle_deg)(time_s))


@pytest.fixture(scope="module")
def linear() -> Array:
    return answer(EXCITATION, lambda y: 0.0)


def test_a_linear_servo_shows_none(linear: Array) -> None:
    """Forty levels at a chance of 1e-3 each: none expected, two would be a chance of 8e-4."""
    chances = []
    for seed in range(20):
        found = distortion(recorded(linear, seed, 125.0 if seed % 2 else 117.3))
        assert found is not None
        chances += [found.odd.chance, found.even.chance]
    assert sum(chance < 1e-3 for chance in chances) <= 1
    # The chances are uniform: the F test is what it says (Kolmogorov and Smirnov, 1 % level).
    ranked = np.sort(chances)
    steps = np.arange(1, ranked.size + 1) / ranked.size
    assert np.max(np.abs(ranked - steps)) < 1.63 / np.sqrt(ranked.size)


def test_cubic_stiffness_is_odd_and_an_offset_square_even() -> None:
    cubic = distortion(recorded(answer(EXCITATION, lambda y: 4e-4 * y**3), 1))
    assert cubic is not None
    assert cubic.odd.found
    assert not cubic.even.found
    assert "Odd distortion" in cubic.sentence
    assert "No even distortion" in cubic.sentence
    square = distortion(recorded(answer(EXCITATION, lambda y: 3e-3 * y * y), 1))
    assert square is not None
    assert square.even.found
    assert not square.odd.found
    assert "one-sided" in square.sentence


def test_levels_are_those_without_noise(linear: Array) -> None:
    """A small load of 1e-3 y^2 deg changes the angle, to first order, by the linear servo's answer
    to that torque: its rms at even lines is what is measured, within what the noise allows.
    """
    angle = answer(EXCITATION, lambda y: 1e-3 * y * y)
    last = slice(-750, None)  # one period of 3 s in frames of 4 ms
    apart = (angle - linear)[last]
    apart -= apart.mean()
    truth = float(np.sqrt(np.mean(apart**2)))
    found = distortion(recorded(angle, 3))
    assert found is not None
    # Lines up to the highest excited one hold most of it; noise at them adds a tenth at most.
    assert found.even.rms_deg == pytest.approx(truth, rel=0.2)
    assert found.even.found


def test_what_it_is_not_made_for(linear: Array) -> None:
    whole = recorded(linear, 0)
    steps = design("steps", CommandLimits(15.0, None, 12.0)).excitation
    other = Recording("steps", steps.time_s, steps.command_deg, whole.time_s, whole.angle_deg)
    assert distortion(other) is None
    short = whole.time_s < 5.0
    cut = Recording(
        "cut",
        EXCITATION.time_s,
        EXCITATION.command_deg,
        whole.time_s[short],
        whole.angle_deg[short],
    )
    with pytest.raises(InputError, match="covers 0 settled periods"):
        distortion(cut)
    slow = Recording(
        "slow",
        EXCITATION.time_s,
        EXCITATION.command_deg,
        whole.time_s[::7],
        whole.angle_deg[::7],
    )
    with pytest.raises(InputError, match="film faster"):
        distortion(slow)


def test_json_lists_every_line(linear: Array) -> None:
    found = distortion(recorded(linear, 0))
    assert found is not None
    values = found.to_json()
    assert len(values["lines"]) == found.response.lines + found.odd.lines + found.even.lines
    assert {line["kind"] for line in values["lines"]} == {"excited", "odd", "even"}
    assert values["response"]["rms_deg"] > 1.0
