"""Each hidden effect against an independent calculation: scipy's integrator or a hand formula.

Truth: the plant equation in degrees of position error, integrated by scipy to 1e-10 with exact
sticking. The noise that a fit has to reach is 0.03 deg, so what the twin adds of its own (creep,
compliance, bounce) must stay below a third of it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.twin_laws import OWN_ERROR_DEG, XI, command, reference, rms, thin, twin

from servosight.models.core import Array, InputError
from servosight.models.excitation import Excitation
from servosight.sim.bench import STEPS_PER_T, BenchParameters
from servosight.sim.run import run

TIMES = [0.0078, 0.02]


@pytest.mark.parametrize("T", TIMES)
def test_dead_time_shifts_by_a_fraction_of_a_step(T: float) -> None:
    time_s, angle = thin(twin(T, "dead_time", delay=0.00777))
    assert 0.00777 * STEPS_PER_T / T % 1.0 > 0.1
    assert np.abs(angle - reference(T, time_s, delay=0.00777)).max() < 0.001


def test_rate_limit_turns_a_jump_into_a_ramp() -> None:
    """Answer to a ramp of 100 deg/s by hand: 100 (t - 2 xi T) once the transient is gone."""
    trajectory = twin(0.02, "rate_limit", rate=100.0)
    time_s, angle = thin(trajectory)
    ramp = (time_s > 0.18) & (time_s < 0.25)  # begins at 0.05, ends at 0.25; 6 T after its start
    lag = 100.0 * (time_s[ramp] - 0.050037 - 2 * XI * 0.02)
    assert np.abs(angle[ramp] - lag).max() < 100 * 0.02 * math.exp(-XI * 0.13 / 0.02) * 1.3
    slow = run(
        BenchParameters.with_response(1.0, 0.02, XI), {"rate_limit": {"rate": 1e9}}, command()
    )
    assert np.abs(thin(slow)[1] - reference(0.02, time_s)).max() < 0.001


def test_rate_limit_that_a_new_jump_cuts_short() -> None:
    """From 0.05 s up at 60 deg/s; at 0.35 s, at 18 deg, down again: the ramp's top is 18."""
    angle = twin(0.02, "rate_limit", rate=60.0)
    line = np.interp(angle.time_s, [0.050037, 0.350037, 0.650037], [0.0, 18.0, 0.0])
    late = (angle.time_s > 0.55) & (angle.time_s < 0.65)
    lag = 60.0 * 2 * XI * 0.02
    assert np.abs(angle.surface_deg[late] - (line[late] + lag)).max() < 0.01


@pytest.mark.parametrize("T", TIMES)
def test_dead_zone(T: float) -> None:
    time_s, angle = thin(twin(T, "dead_zone", half_width=1.3))
    truth = reference(T, time_s, drive=lambda e, _: e - min(max(e, -1.3), 1.3))
    assert np.abs(angle - truth).max() < 0.001


@pytest.mark.parametrize("T", TIMES)
def test_torque_saturation(T: float) -> None:
    time_s, angle = thin(twin(T, "torque_saturation", limit=4.0))
    truth = reference(T, time_s, drive=lambda e, _: min(max(e, -4.0), 4.0))
    assert np.abs(angle - truth).max() < 0.002


@pytest.mark.parametrize("T", TIMES)
def test_coulomb_friction(T: float) -> None:
    time_s, angle = thin(twin(T, "coulomb_friction", level=1.2))
    truth = reference(T, time_s, friction=lambda *_: 1.2)
    assert rms(angle - truth) < OWN_ERROR_DEG


def test_friction_at_four_fifths_of_breakaway_does_not_creep() -> None:
    """Bound: 0.002 deg in 100 ms; at MuJoCo's default softness it slips 0.3 deg."""
    push = Excitation(np.array([0.0, 0.1, 0.2, 0.3]), np.array([0.0, 0.8, 0.8, 0.8]))
    bench = BenchParameters.with_response(1.0, 0.02, XI)
    held = run(bench, {"coulomb_friction": {"level": 1.0}}, push).surface_deg
    assert np.ptp(held) < 0.002
    loose = run(bench, {"coulomb_friction": {"level": 0.79}}, push).surface_deg
    assert np.ptp(loose) > 0.005


@pytest.mark.parametrize("T", TIMES)
def test_load_dependent_friction(T: float) -> None:
    time_s, angle = thin(twin(T, "load_dependent_friction", ratio=0.5))
    truth = reference(T, time_s, friction=lambda torque, _: 0.5 * abs(torque))
    assert rms(angle - truth) < OWN_ERROR_DEG


@pytest.mark.parametrize(("sine", "cosine"), [(5.0, 12.0), (-6.0, -3.0)])
def test_gravity_load(sine: float, cosine: float) -> None:
    """Compared once the start, from rest without load in the reference, has died away."""
    time_s, angle = thin(twin(0.02, "gravity_load", sine=sine, cosine=cosine))

    def load(theta: float) -> float:
        a = math.radians(theta)
        return sine * math.sin(a) + cosine * math.cos(a)

    truth = reference(0.02, time_s, load=load)
    settled = time_s > 0.5
    assert np.abs(angle - truth)[settled].max() < 0.001
    at_rest = float(angle[0])
    assert at_rest == pytest.approx(-load(at_rest), abs=1e-4)


@pytest.mark.parametrize("limit", [4.0, math.inf])
def test_an_integral_holds_a_weight_up_to_its_limit(limit: float) -> None:
    """By hand: of a weight of 9 deg the loop holds what the integral leaves, nothing without a
    limit."""
    still = Excitation(np.array([0.0, 2.0]), np.zeros(2))
    hidden = {
        "limited_integral": {"rate": 20.0, "lag": 0.0, "limit": limit},
        "gravity_load": {"sine": 0.0, "cosine": 9.0},
    }
    bench = BenchParameters.with_response(1.0, 0.02, XI)
    at_rest = float(run(bench, hidden, still).surface_deg[-1])
    missing = at_rest + 9.0 * math.cos(math.radians(at_rest))
    assert missing == pytest.approx(min(limit, 9.0), abs=1e-3)


@pytest.mark.parametrize(("frequency", "damping", "share"), [(12.0, 0.08, 0.3), (25.0, 0.05, 0.7)])
def test_flexible_shaft(frequency: float, damping: float, share: float) -> None:
    """Both inertias as a linear system, stepped exactly by its matrix exponential."""
    from scipy.linalg import expm

    T, omega = 0.02, 2 * math.pi * frequency
    trajectory = twin(
        T, "flexible_shaft", frequency=frequency, damping=damping, inertia_ratio=share
    )
    spring, damper = omega**2, 2 * damping * omega
    near = (1 - share) * T**2
    back = share * T**2 / near
    system = np.zeros((5, 5))  # theta, w, far theta, far w, and the held command
    system[0, 1] = system[2, 3] = 1.0
    system[3, :4] = spring, damper, -spring, -damper
    system[1, :4] = -back * system[3, :4]
    system[1, :2] += -1 / near, -2 * XI * T / near
    system[1, 4] = 1 / near
    rows = command()
    x = np.zeros(5)
    for u, t, end in zip(rows.command_deg, rows.time_s, rows.time_s[1:], strict=False):
        x[4] = u
        for at in np.linspace(t, end, 4)[1:]:
            now = expm(system * (at - t)) @ x
            assert abs(float(trajectory.angle_at(np.array([at]))[0]) - now[2]) < 0.003
        x = now
    assert np.ptp(trajectory.motor_deg - trajectory.surface_deg) > 1.0


def test_a_shaft_too_stiff_for_the_time_step_is_refused() -> None:
    with pytest.raises(InputError, match="at most 17 Hz"):
        twin(0.02, "flexible_shaft", frequency=1000.0, damping=0.08, inertia_ratio=0.95)


@pytest.mark.parametrize("T", TIMES)
@pytest.mark.parametrize("gap", [0.6, 3.0])
def test_backlash_is_the_play_operator(T: float, gap: float) -> None:
    """Play operator on the exact linear motion; its gap within 2.4 %, its rest below the noise."""
    trajectory = twin(T, "backlash", gap=gap)
    time_s, angle = thin(trajectory)
    assert rms(trajectory.motor_deg[::11] - reference(T, time_s)) < 0.003

    def play(width: float) -> Array:
        at = 0.0
        out = np.empty_like(trajectory.motor_deg)
        for n, theta in enumerate(trajectory.motor_deg):
            at = min(max(at, theta - 0.5 * width), theta + 0.5 * width)
            out[n] = at
        return out[::11]

    assert rms(angle - play(gap)) < OWN_ERROR_DEG
    widths = gap * np.linspace(0.95, 1.05, 41)
    best = widths[np.argmin([rms(angle - play(width)) for width in widths])]
    assert best == pytest.approx(gap, rel=0.024)


DRIVES: dict[str, tuple[dict[str, float], dict[str, Any]]] = {
    "asymmetric_gain": ({"ratio": 0.7}, {"drive": lambda e, _: e if e > 0.0 else 0.7 * e}),
    "speed_limit": (
        {"stall": 12.0, "no_load_speed": 250.0},
        {
            "drive": lambda e, w: (
                min(e, max(12.0 * (1.0 - w / 250.0), 0.0))
                if e > 0.0
                else max(e, min(-12.0 * (1.0 + w / 250.0), 0.0))
            )
        },
    ),
    "dead_band": (
        {"half_width": 1.3},
        {"drive": lambda e, _: math.copysign(min(abs(e), max(5.0 * (abs(e) - 1.3), 0.0)), e)},
    ),
    "current_limit": (
        {"limit": 3.0, "back_emf": 0.006},
        {"drive": lambda e, w: min(max(e, 0.006 * w - 3.0), 0.006 * w + 3.0)},
    ),
    "stribeck_friction": (
        {"level": 0.6, "excess": 0.7, "speed": 20.0},
        {"friction": lambda _, w: 0.6 + 0.7 * math.exp(-((w / 20.0) ** 2))},
    ),
    "quadratic_drag": ({"coefficient": 3e-4}, {"drive": lambda e, w: e - 3e-4 * w * abs(w)}),
    "hinge_hardening": ({"cubic": 8e-4}, {"load": lambda a: 8e-4 * a**3}),
    "cogging": (
        {"amplitude": 0.9, "period": 14.0, "phase": 0.0},
        {"load": lambda a: 0.9 * math.sin(2.0 * math.pi * a / 14.0)},
    ),
    "sensor_nonlinearity": (
        {"amplitude": 1.2, "period": 25.0, "phase": 0.0},
        {"sensor": lambda a: a + 1.2 * math.sin(2.0 * math.pi * a / 25.0)},
    ),
}


@pytest.mark.parametrize("T", TIMES)
@pytest.mark.parametrize("effect", DRIVES)
def test_laws_of_angle_and_speed_against_scipy(T: float, effect: str) -> None:
    values, law = DRIVES[effect]
    time_s, angle = thin(twin(T, effect, **values))
    error = rms(angle - reference(T, time_s, **law))
    print(f"{effect} at T = {T}: {error:.5f} deg rms")
    assert error < OWN_ERROR_DEG / 3.0


def test_presliding_bends_by_dahls_law_and_does_not_drift() -> None:
    """Loaded slowly, F = level (1 - exp(-s theta/level)), and at rest e = F with e = u - theta.

    Bound: a thousandth of the travel, for the ringing at each row of the ramp.
    """
    rows = np.append(np.arange(501) * 0.004, 3.0)
    push = Excitation(rows, np.minimum(rows / 2.0, 1.0))
    bench = BenchParameters.with_response(1.0, 0.02, 1.2)
    held = run(bench, {"presliding": {"level": 1.0, "stiffness": 4.0}}, push)
    end = float(held.surface_deg[-1])
    assert 1.0 - end == pytest.approx(1.0 - math.exp(-4.0 * end), abs=1e-3)
    assert np.ptp(held.surface_deg[held.time_s > 2.2]) < 1e-4
