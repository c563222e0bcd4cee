"""Describing functions against their closed forms, and limit cycles predicted with them.

Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968,
appendix B: play and quantizer.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import control
import numpy as np
import pytest
from scipy.optimize import fsolve
from support.servo import actuator

from servosight.models.core import InputError

CORE = {"k": 1.0, "T": 0.02, "xi": 0.6, "bias": 0.0}
GAP = 0.6


def core(frequency_hz: float) -> complex:
    """G of the linear core."""
    s = 2j * math.pi * frequency_hz
    return 1.0 / (CORE["T"] ** 2 * s * s + 2.0 * CORE["xi"] * CORE["T"] * s + 1.0)


def play(amplitude: float) -> complex:
    """Of a play of full width ``GAP``, for a sine that is larger than half of it."""
    r = 0.5 * GAP / amplitude
    x = 1.0 - 2.0 * r
    real = 0.5 + (math.asin(x) + x * math.sqrt(1.0 - x * x)) / math.pi
    return complex(real, -4.0 / math.pi * r * (1.0 - r))


def rounding(amplitude: float, step: float) -> complex:
    """Of a quantizer that rounds to multiples of ``step``."""
    edges = step * (np.arange(int(amplitude / step + 0.5)) + 0.5)
    return complex(
        np.sum(4.0 * step / (math.pi * amplitude) * np.sqrt(1 - (edges / amplitude) ** 2))
    )


@pytest.mark.parametrize("frequency_hz", [0.5, 5.0, 20.0])
def test_without_effects_it_is_the_transfer_function(frequency_hz: float) -> None:
    servo = actuator(CORE, dead_time__delay=0.01)
    late = np.exp(-2j * math.pi * frequency_hz * 0.01)
    found = servo.describing_function(3.0, frequency_hz, offset_deg=7.0)
    assert found == pytest.approx(core(frequency_hz) * late, abs=2e-4)


@pytest.mark.parametrize("frequency_hz", [0.05, 0.5, 5.0])
@pytest.mark.parametrize(("rate", "lag"), [(3.0, 0.0), (20.0, 0.05)])
def test_with_an_integral_it_is_the_transfer_function_of_third_order(
    rate: float, lag: float, frequency_hz: float
) -> None:
    servo = actuator(CORE, integral_action__rate=rate, integral_action__lag=lag)
    s = 2j * math.pi * frequency_hz
    expected = (1.0 + rate / s) / (1.0 / core(frequency_hz) + rate * lag + rate / s)
    assert servo.describing_function(3.0, frequency_hz) == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize("amplitude_deg", [0.35, 0.6, 3.0])
@pytest.mark.parametrize("frequency_hz", [0.2, 4.0])
def test_play_agrees_with_its_closed_form(amplitude_deg: float, frequency_hz: float) -> None:
    servo = actuator(CORE, backlash__gap=GAP)
    horn = core(frequency_hz)
    expected = horn * play(amplitude_deg * abs(horn))
    assert servo.describing_function(amplitude_deg, frequency_hz) == pytest.approx(
        expected, abs=0.003
    )


def test_a_quantizer_agrees_with_its_closed_form() -> None:
    servo = actuator(CORE, command_quantization__step=1.0)
    for amplitude in (0.4, 0.8, 3.3):
        expected = rounding(amplitude, 1.0) * core(0.05)
        found = servo.describing_function(amplitude, 0.05)
        assert found == pytest.approx(expected, abs=0.01)


def loop_of(kp: float, ki: float, kd: float) -> control.TransferFunction:
    """PID with a rate-limited derivative, times a vehicle that rolls."""
    pilot = control.tf([kp], [1]) + control.tf([ki], [1, 0]) + control.tf([kd, 0], [0.005, 1])
    return pilot * control.tf([60.0], [1.0, 3.0, 0.0])


def balanced(loop: Callable[[complex], complex], start: tuple[float, float]) -> tuple[float, float]:
    """Command's amplitude and frequency of a limit cycle, by the closed forms."""

    def left(x: list[float]) -> tuple[float, float]:
        horn = core(x[1])
        whole = 1.0 + loop(2j * math.pi * x[1]) * horn * play(x[0] * abs(horn))
        return whole.real, whole.imag

    amplitude, frequency = fsolve(left, start)
    return float(amplitude), float(frequency)


def test_the_limit_cycle_that_play_makes() -> None:
    loop = loop_of(2.0, 4.0, 0.15)
    (cycle,) = actuator(CORE, backlash__gap=GAP).limit_cycles(loop)
    amplitude, frequency = balanced(loop, (0.6, 1.4))
    assert cycle.command_deg == pytest.approx(amplitude, rel=5e-3)
    assert cycle.frequency_hz == pytest.approx(frequency, rel=5e-3)
    assert cycle.stable
    horn = core(frequency)
    assert cycle.angle_deg == pytest.approx(
        amplitude * abs(horn * play(amplitude * abs(horn))), rel=1e-2
    )


def test_an_unstable_limit_cycle_is_the_border_of_a_stable_one() -> None:
    """Close to tangency there are two: the smaller is unstable."""
    small, large = actuator(CORE, backlash__gap=GAP).limit_cycles(loop_of(1.0, 0.0, 0.1))
    assert small.angle_deg < large.angle_deg
    assert (small.stable, large.stable) == (False, True)


def test_a_well_damped_loop_has_none() -> None:
    assert actuator(CORE, backlash__gap=GAP).limit_cycles(loop_of(1.0, 0.0, 0.2)) == ()


@pytest.mark.parametrize(("amplitude_deg", "frequency_hz"), [(0.0, 1.0), (1.0, math.nan)])
def test_what_is_no_sine_is_refused(amplitude_deg: float, frequency_hz: float) -> None:
    with pytest.raises(InputError, match="expected a number above 0"):
        actuator(CORE).describing_function(amplitude_deg, frequency_hz)
