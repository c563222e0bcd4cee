"""The desired speed that a loop is given: by formula, and against a controller that MuJoCo has."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from servosight.identify.fit import identify
from servosight.identify.problem import BaseModel, Problem, effect_starts, linear_start
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.effects.builtin.velocity_feedforward import term
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus

LEAD, T, XI = 0.03, 0.04, 0.9
EFFECT = "velocity_feedforward"


def through(
    *pieces: tuple[float, float, float], at: float, cut_s: float = math.inf
) -> list[tuple[float, float, float]]:
    """Duration and first and last speed [deg/s] over pieces (value, slope, horizon), from rest.

    ``cut_s`` is the longest time for which one answer of the term is taken.
    """
    found, before = [], 0.0
    for value, slope, horizon in pieces:
        gone = 0.0
        while gone < horizon - 1e-12:
            now = value + slope * gone
            out, rise, lasts, rate, change = term(now, slope, horizon - gone, 0.0, at, before, LEAD)
            lasts = min(lasts, cut_s)
            speeds = (out - now) / LEAD, (out - now) / LEAD + (rise - slope) * lasts / LEAD
            found.append((lasts, *speeds))
            at += rate * lasts
            before += change * lasts
            gone += lasts
    return found


@pytest.mark.parametrize("row_s", [2e-4, 0.004, 0.01, 0.02, 0.4])
def test_a_jump_is_a_kick_of_one_size_at_one_time(row_s: float) -> None:
    """As an impulse at its instant: the integral is the jump, and its first moment about it 0.

    It is over with the next row, or as much of a long one; rows below 1 ms smear it over some.
    """
    found = through(*[(5.0, 0.0, row_s)] * 60, at=2.0)
    starts = np.cumsum([0.0, *(lasts for lasts, *_ in found)])[:-1]
    area = sum(lasts * 0.5 * (first + last) for lasts, first, last in found)
    assert area == pytest.approx(3.0, rel=1e-4)
    if row_s >= 1e-3:
        lasts = row_s / math.ceil(row_s / 0.032)
        assert found[0] == pytest.approx((lasts, 6.0 / lasts, 3.0 / lasts))
        assert found[1] == pytest.approx((lasts, -3.0 / lasts, 0.0), abs=1e-9)
        assert all(abs(first) < 1e-5 for _, first, _ in found[2:])
        moment = sum(
            t * h * 0.5 * (a + b) + h * h * (a + 2.0 * b) / 6.0
            for t, (h, a, b) in zip(starts, found, strict=True)
        )
        assert abs(moment) < 3.0 * lasts / 5.0


def test_even_motion_has_its_speed() -> None:
    """From the second row on; a line has it at once."""
    rows = [(0.2 * n, 0.0, 0.005) for n in range(1, 6)]
    assert through(*rows, at=0.0)[1:] == [(0.005, pytest.approx(40.0), pytest.approx(40.0))] * 4
    assert through((2.0, 40.0, 0.3), at=2.0) == [(0.3, pytest.approx(40.0), pytest.approx(40.0))]


def test_a_row_that_is_cut_goes_on() -> None:
    """Where another term or a disturbance ends a piece within the row."""
    rows = (5.0, 0.0, 0.008), (6.0, 0.0, 0.008)
    whole, parts = through(*rows, at=2.0), through(*rows, at=2.0, cut_s=0.004)
    assert [found[1] for found in parts[::2]] == pytest.approx([found[1] for found in whole])
    assert [found[2] for found in parts[1::2]] == pytest.approx([found[2] for found in whole])
    assert [found[2] for found in parts[::2]] == pytest.approx([found[1] for found in parts[1::2]])


def row_of(**values: float) -> tuple[Plant, Array]:
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    for name, value in values.items():
        row[plant.index(name.replace("__", "."))] = value
    return plant, row


def test_a_command_that_has_always_been_there_gives_no_kick() -> None:
    plant, row = row_of(k=1.0, T=T, xi=XI, initial_angle=20.0, velocity_feedforward__lead=LEAD)
    time_s = np.arange(0.0, 0.5, 0.003)
    held = Stimulus(np.array([0.0, 0.3]), np.array([20.0, 20.0]), False, time_s, np.ones(1))
    assert np.abs(plant.simulate(row, held) - 20.0).max() < 1e-9


def test_a_fit_begins_with_a_lag_that_is_longer_by_the_lead() -> None:
    time_s = np.arange(0.0, 3.0, 0.01)
    wanted = smooth(time_s)
    log = Recording("log", time_s, wanted, time_s, np.interp(time_s - 0.02, time_s, wanted))
    linear = Problem.of([log], catalogue(), ())
    base = BaseModel(linear, linear_start(linear))
    led = Problem.of([log], catalogue(), (EFFECT,))
    before = linear.values(base.point)
    for point in effect_starts(led, base):
        found = led.values(point)
        added = 2.0 * (found["xi"] * found["T"] - before["xi"] * before["T"])
        assert added == pytest.approx(0.0, abs=1e-9) or added == pytest.approx(
            found[f"{EFFECT}.lead"]
        )


@pytest.mark.parametrize("frequency_hz", [0.7, 2.0, 5.0])
def test_the_transfer_function_has_a_zero(frequency_hz: float) -> None:
    """G = k (1 + lead s) / (T^2 s^2 + 2 xi T s + 1). The command is joined by lines of 2 ms: these
    make its amplitude less by (omega 2 ms)^2 / 12, and its derivative is late by 1 ms at most."""
    plant, row = row_of(k=1.1, T=T, xi=XI, velocity_feedforward__lead=LEAD)
    omega = 2.0 * math.pi * frequency_hz
    rows_s = np.arange(0.0, 4.01, 0.002)
    time_s = np.arange(0.0, 4.0, 0.0037)
    asked = Stimulus(rows_s, 10.0 * np.sin(omega * rows_s), True, time_s, np.ones(1))
    s = 1j * omega
    gain = 1.1 * (1.0 + LEAD * s) / ((T * s) ** 2 + 2.0 * XI * T * s + 1.0)
    truth = np.imag(10.0 * gain * np.exp(s * time_s))
    bound = 10.0 * abs(gain) * (omega * 0.002) ** 2 / 12.0 + 1e-6
    error = float(np.abs(plant.simulate(row, asked) - truth)[time_s > 2.0].max())
    print(f"{frequency_hz} Hz: {error:.2e} deg, bound {bound:.2e}")
    assert error < 2.0 * bound


def impedance(rows_s: Array, angle: Array, speed: Array, *, kp: float, kd: float) -> Array:
    """What MuJoCo makes of angle and speed wanted by a position and a velocity actuator [rad].

    The joint has an inertia of kp T^2 and a damping of its own beside kd. Both are held from row to
    row, as a motor driver has them off its bus. Angles at the rows.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = 1e-4
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    body = spec.worldbody.add_body(name="arm", explicitinertial=True, mass=1e-6, inertia=[1e-9] * 3)
    joint = body.add_joint(name="motor", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    joint.armature = kp * T**2
    joint.damping = [2.0 * XI * T * kp - kd, 0.0, 0.0]
    by_angle = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor")
    by_angle.set_to_position(kp=kp)
    by_speed = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor")
    by_speed.set_to_velocity(kv=kd)
    model = spec.compile()
    data = mujoco.MjData(model)
    found = np.empty_like(rows_s)
    for n, (wanted, rate) in enumerate(zip(angle, speed, strict=True)):
        found[n] = data.qpos[0]
        data.ctrl[:] = wanted, rate
        for _ in range(round(float(rows_s[1]) / 1e-4)):
            mujoco.mj_step(model, data)
    return found


def smooth(time_s: Array) -> Array:
    """Four tones, from rest [deg]."""
    tones = [(25.0, 0.4, 0.0), (10.0, 1.1, 1.0), (4.0, 2.7, 2.0), (1.5, 5.1, 4.0)]
    soft = 1.0 - np.exp(-((time_s / 0.3) ** 2))
    return soft * sum(a * np.sin(2.0 * np.pi * f * time_s + p) for a, f, p in tones)


@pytest.mark.parametrize(("rate_hz", "off"), [(1000.0, 0.0), (250.0, 0.0), (100.0, 0.1)])
def test_a_speed_that_a_host_sends_is_recovered(rate_hz: float, off: float) -> None:
    """Truth: MuJoCo's own actuators with kd / kp = lead, given the trajectory's true derivative.

    Bounds: 3 sigma; at 100 Hz the second difference errs by (omega row)^2 / 3, 1 to 3 % of the
    faster tones' speed, and T and xi, which do much the same, leave some times that to the lead.
    """
    rows_s = np.arange(0.0, 8.0, 1.0 / rate_hz)
    wanted, h = smooth(rows_s), 1e-5
    speed = (smooth(rows_s + h) - smooth(rows_s - h)) / (2.0 * h)
    angle = impedance(rows_s, np.radians(wanted), np.radians(speed), kp=2.0, kd=2.0 * LEAD)
    noisy = np.degrees(angle) + np.random.default_rng(2).normal(0.0, 0.02, rows_s.size)
    log = Recording("mit", rows_s, wanted, rows_s, noisy)
    found = identify([log], [EFFECT], catalogue=catalogue(), method="gradient")
    for name, value in {"T": T, "xi": XI, f"{EFFECT}.lead": LEAD, "k": 1.0}.items():
        own = found.parameters[name]
        assert own.sigma is not None
        print(f"{rate_hz} Hz, {name}: truth {value}, found {own.value:.5f} +- {own.sigma:.5f}")
        assert abs(own.value - value) < max(3.0 * own.sigma, off * value), name


def test_a_derivative_that_a_firmware_takes_is_recovered() -> None:
    """Truth: a controller that differences its set-point each millisecond, behind a sender of 250
    Hz, with steps. The kick has the same size and time over two rows of 4 ms; what its shape
    leaves is below the noise, and 1 % of each parameter bounds the rest."""
    command = standard(12.0, 20.0, seed=3, rate_hz=250.0)
    values = {"k": 1.0, "T": 0.02, "xi": 0.55, f"{EFFECT}.lead": 0.014}
    plant, row = row_of(**{name.replace(".", "__"): value for name, value in values.items()})
    cycles = np.repeat(command.command_deg, 4)
    time_s = np.arange(0.0, 11.9, 1.0 / 120.0)
    asked = Stimulus(np.arange(cycles.size) / 1000.0, cycles, False, time_s, np.ones(1))
    angle = plant.simulate(row, asked) + np.random.default_rng(1).normal(0.0, 0.03, time_s.size)
    log = Recording("pid", command.time_s, command.command_deg, time_s, angle)
    found = identify([log], [EFFECT], catalogue=catalogue(), method="gradient")
    assert found.rmse_deg < math.hypot(0.03, 0.03)
    for name, value in values.items():
        print(f"{name}: truth {value}, found {found.parameters[name].value:.5f}")
        assert found.parameters[name].value == pytest.approx(value, rel=0.01)
