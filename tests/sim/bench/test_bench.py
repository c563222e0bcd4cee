"""The effect-free twin against its closed form: k / (T^2 s^2 + 2 xi T s + 1)."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.models.excitation import Excitation, sine, standard
from servosight.sim.bench import BenchParameters
from servosight.sim.run import run


def step_response(T: float, xi: float, time_s: Array) -> Array:
    """Unit step response for xi < 1 (hand formula)."""
    root = np.sqrt(1.0 - xi**2)
    phase = root * time_s / T
    ringing = np.cos(phase) + xi / root * np.sin(phase)
    return np.where(time_s > 0.0, 1.0 - np.exp(-xi * time_s / T) * ringing, 0.0)


def superposed(bench: BenchParameters, excitation: Excitation, time_s: Array) -> Array:
    """Exact answer to a held command: one step response for each row."""
    jumps = np.diff(excitation.command_deg, prepend=excitation.command_deg[0])
    answer = np.full(time_s.size, bench.k * excitation.command_deg[0] + bench.bias_deg)
    for start, jump in zip(excitation.time_s, jumps, strict=True):
        if jump:
            answer += bench.k * jump * step_response(bench.T, bench.xi, time_s - start)
    return answer


@pytest.mark.parametrize("T", [0.0078, 0.02, 0.1])
def test_wanted_response_is_the_closed_form_of_the_parts(T: float) -> None:
    bench = BenchParameters.with_response(k=-1.027, T=T, xi=0.55, bias_deg=2.0)
    assert (bench.k, bench.T, bench.xi) == pytest.approx((-1.027, T, 0.55), rel=1e-12)
    assert bench.rotor_inertia_kg_m2 > 0.0
    assert bench.viscous_damping_nms_rad > 0.0


def test_default_parts_make_the_default_response() -> None:
    bench = BenchParameters()
    assert (bench.k, bench.T, bench.xi) == pytest.approx((1.0, 0.02, 0.6), rel=2e-4)


@pytest.mark.parametrize("T", [0.0, 0.001, -1.0, float("nan")])
def test_a_response_that_the_step_cannot_resolve_is_refused(T: float) -> None:
    with pytest.raises(ValueError, match="expected T"):
        BenchParameters.with_response(T=T)


@pytest.mark.parametrize(("T", "xi"), [(0.0078, 0.55), (0.02, 0.6), (0.1, 0.9)])
def test_integration_error_is_far_below_the_noise(T: float, xi: float) -> None:
    """Bound: 0.003 deg, a tenth of the noise; a lag of half a time step alone would be 0.005."""
    bench = BenchParameters.with_response(1.1, T, xi, bias_deg=-0.7)
    command = standard(3.0, seed=2)
    twin = run(bench, {}, command)
    error = twin.surface_deg[::7] - superposed(bench, command, twin.time_s[::7])
    assert np.abs(error).max() < 1e-5
    np.testing.assert_array_equal(twin.motor_deg, twin.surface_deg)


def test_rows_between_time_steps_do_not_become_a_delay() -> None:
    """Jumps at thirds of the 0.1 ms step: rounding one would shift 300 deg/s by 0.01 deg."""
    bench = BenchParameters.with_response(T=0.0078)
    command = Excitation(
        np.array([0.0, 0.010033, 0.200067, 0.3]), np.array([0.0, 20.0, -15.0, -15.0])
    )
    twin = run(bench, {}, command)
    error = twin.surface_deg - superposed(bench, command, twin.time_s)
    assert np.abs(error).max() < 1e-5


@pytest.mark.parametrize("frequency_hz", [1.0, 8.0, 20.0])
def test_frequency_response_is_the_transfer_function(frequency_hz: float) -> None:
    bench = BenchParameters.with_response(1.02, 0.02, 0.6)
    time_s = np.arange(30_001) / 10_000.0
    twin = run(bench, {}, Excitation(time_s, sine(time_s, 10.0, frequency_hz)))
    s = 2j * np.pi * frequency_hz
    late = twin.time_s >= 2.0 - 1e-9  # whole periods, transients gone
    wave = np.exp(-s * twin.time_s[late][:-1])
    answer = 2j * np.mean(twin.surface_deg[late][:-1] * wave) / 10.0
    hold = np.exp(-s * 0.5e-4) * np.sinc(frequency_hz * 1e-4)  # the command's rows are held
    expected = hold * bench.k / (bench.T**2 * s**2 + 2.0 * bench.xi * bench.T * s + 1.0)
    assert abs(answer - expected) < 1e-5


def test_command_column_is_the_held_command() -> None:
    command = Excitation(np.array([1.0, 1.5, 2.0]), np.array([3.0, -4.0, 5.0]))
    twin = run(BenchParameters(), {}, command)
    assert twin.time_s[0] == 1.0
    assert twin.duration_s == pytest.approx(1.0)
    assert set(twin.command_deg[twin.time_s < 1.4999]) == {3.0}
    assert set(twin.command_deg[(twin.time_s > 1.5001) & (twin.time_s < 1.9999)]) == {-4.0}
    assert twin.surface_deg[0] == pytest.approx(3.0, abs=1e-9)  # at rest under the first row


def test_rows_off_the_grid_leave_the_trajectory_on_it() -> None:
    command = Excitation(np.arange(9) / 300.0, np.arange(9.0))
    twin = run(BenchParameters(), {}, command)
    np.testing.assert_allclose(np.diff(twin.time_s), 1e-4, rtol=1e-9)
    assert twin.time_s.size == twin.motor_deg.size == twin.surface_deg.size
    assert twin.time_s.size == twin.command_deg.size
