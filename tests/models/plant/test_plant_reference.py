"""The compiled plant against the same equation solved by scipy to 1e-10 (support/reference.py).

Bound: 0.002 deg at the default step, at T = 7.8 ms and xi = 0.55, on steps of 20 deg and a chirp to
12 Hz. The smallest noise a fit is expected to reach is ten times that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus

BOUND_DEG = 0.002
T, XI = 0.0078, 0.55

CASES: dict[str, dict[str, dict[str, float]]] = {
    "linear": {},
    "dead_time": {"dead_time": {"delay": 0.00777}},
    "rate_limit": {"rate_limit": {"rate": 150.0}},
    "velocity_feedforward": {"velocity_feedforward": {"lead": 0.006}},
    "late and led": {"dead_time": {"delay": 0.0123}, "velocity_feedforward": {"lead": 0.02}},
    "dead_zone": {"dead_zone": {"half_width": 1.3}},
    "dead_band": {"dead_band": {"half_width": 1.3}},
    "dead band under a weight": {
        "dead_band": {"half_width": 0.6},
        "gravity_load": {"sine": 3.0, "cosine": 2.0},
    },
    "dead band and friction": {
        "dead_band": {"half_width": 0.6},
        "coulomb_friction": {"level": 0.3},
    },
    "torque_saturation": {"torque_saturation": {"limit": 4.0}},
    "coulomb_friction": {"coulomb_friction": {"level": 1.2}},
    "load_dependent_friction": {"load_dependent_friction": {"ratio": 0.4}},
    "gravity_load": {"gravity_load": {"sine": 5.0, "cosine": 12.0}},
    "flexible_shaft": {
        "flexible_shaft": {"frequency": 12.0, "damping": 0.08, "inertia_ratio": 0.3}
    },
    "stiff shaft": {"flexible_shaft": {"frequency": 60.0, "damping": 0.02, "inertia_ratio": 0.6}},
    "backlash": {"backlash": {"gap": 2.0}},
    "command_quantization": {"command_quantization": {"step": 1.7}},
    "asymmetric_gain": {"asymmetric_gain": {"ratio": 0.6}},
    "speed_limit": {"speed_limit": {"stall": 9.0, "no_load_speed": 500.0}},
    "low voltage line": {"speed_limit": {"stall": 40.0, "no_load_speed": 150.0}},
    "current_limit": {"current_limit": {"limit": 3.0, "back_emf": 0.005}},
    "stribeck_friction": {"stribeck_friction": {"level": 0.6, "excess": 0.8, "speed": 15.0}},
    "presliding": {"presliding": {"level": 1.2, "stiffness": 6.0}},
    "stiff presliding": {"presliding": {"level": 1.0, "stiffness": 80.0}},
    "quadratic_drag": {"quadratic_drag": {"coefficient": 5e-5}},
    "thick drag": {"quadratic_drag": {"coefficient": 5e-4}},
    "hinge_hardening": {"hinge_hardening": {"cubic": 2e-3}},
    "cogging": {"cogging": {"amplitude": 1.5, "period": 7.0, "phase": 0.4}},
    "fine cogging": {"cogging": {"amplitude": 0.6, "period": 1.2, "phase": -2.0}},
    "supply_sag": {"supply_sag": {"sag": 0.03, "time": 0.05}},
    "integral_action": {"integral_action": {"rate": 15.0, "lag": 0.02}},
    "limited_integral": {"limited_integral": {"rate": 15.0, "lag": 0.0, "limit": 1.5}},
    "integral action that holds a weight against friction": {
        "integral_action": {"rate": 10.0, "lag": 0.03},
        "coulomb_friction": {"level": 0.8},
        "gravity_load": {"sine": 5.0, "cosine": 12.0},
    },
    "linkage_geometry": {"linkage_geometry": {"horn": 1.2, "offset": 15.0}},
    "sensor_nonlinearity": {
        "sensor_nonlinearity": {"amplitude": 1.2, "period": 25.0, "phase": 2.5}
    },
    "feedback_backlash": {"feedback_backlash": {"gap": 1.5}},
    "drag, sag and cogging": {
        "quadratic_drag": {"coefficient": 3e-5},
        "supply_sag": {"sag": 0.02, "time": 0.1},
        "cogging": {"amplitude": 1.0, "period": 11.0, "phase": 0.4},
    },
    "stribeck behind a weak side": {
        "asymmetric_gain": {"ratio": 1.4},
        "stribeck_friction": {"level": 0.5, "excess": 0.5, "speed": 20.0},
        "hinge_hardening": {"cubic": 1e-3},
    },
    "both frictions": {
        "coulomb_friction": {"level": 0.6},
        "load_dependent_friction": {"ratio": 0.3},
    },
    "friction by load under a weight": {
        "load_dependent_friction": {"ratio": 0.3},
        "gravity_load": {"sine": 3.0, "cosine": 12.0},
    },
    "friction by both sides under a weight": {
        "directional_friction": {"motor": 0.3, "outer": 0.15, "back_emf": 0.015},
        "gravity_load": {"sine": 3.0, "cosine": 12.0},
    },
    "friction by the torque, less at speed": {
        "coulomb_friction": {"level": 0.5},
        "load_dependent_stribeck": {"excess": 0.3, "speed": 60.0, "back_emf": 0.015},
        "gravity_load": {"sine": 3.0, "cosine": 12.0},
    },
    "limits and friction": {
        "dead_zone": {"half_width": 0.5},
        "torque_saturation": {"limit": 6.0},
        "coulomb_friction": {"level": 0.8},
        "gravity_load": {"sine": 2.0, "cosine": -4.0},
        "backlash": {"gap": 1.0},
    },
    "late and limited": {"dead_time": {"delay": 0.0123}, "rate_limit": {"rate": 200.0}},
    "shaft behind friction": {
        "coulomb_friction": {"level": 1.0},
        "flexible_shaft": {"frequency": 15.0, "damping": 0.1, "inertia_ratio": 0.3},
    },
    "shaft and gap": {
        "flexible_shaft": {"frequency": 15.0, "damping": 0.1, "inertia_ratio": 0.3},
        "backlash": {"gap": 1.0},
    },
}


def steps() -> tuple[Array, Array]:
    """Large and small jumps at instants on no grid."""
    time_s = np.array([0.0, 0.0531, 0.2003, 0.3517, 0.4409, 0.5211, 0.6007, 0.7001])
    return time_s, np.array([0.0, 20.0, -12.0, 3.0, 4.5, 1.0, 1.2, 1.0])


def stairs() -> tuple[Array, Array]:
    """A chirp of 12 deg to 12 Hz, as a sender holds it at 100 Hz."""
    time_s = np.arange(0.0, 1.0, 0.01)
    return time_s, 12.0 * np.sin(2 * np.pi * (1.0 * time_s + 5.5 * time_s**2))


def simulated(
    effects: dict[str, dict[str, float]],
    rows: tuple[Array, Array],
    samples: Array,
    *,
    linear: bool = False,
    **base: float,
) -> Array:
    """The plant's angle for the effects, all else neutral."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    values: dict[str, float] = {"k": 1.0, "T": T, "xi": XI, **base}
    for effect, parameters in effects.items():
        values |= {f"{effect}.{name}": value for name, value in parameters.items()}
    for name, value in values.items():
        row[plant.index(name)] = value
    return plant.simulate(row, Stimulus(*rows, linear, samples, np.ones(1)))


@pytest.mark.parametrize("excitation", [steps, stairs])
@pytest.mark.parametrize("case", CASES)
def test_at_the_default_step(case: str, excitation: Any, reference: Any) -> None:
    effects = CASES[case]
    rows = excitation()
    samples = np.arange(0.0, rows[0][-1] + 0.1, 0.0013)
    truth = reference(1.0, T, XI, effects=effects).solve(*rows, samples)
    error = np.abs(simulated(effects, rows, samples) - truth)
    print(f"{case}: {error.max():.2e} deg")
    assert error.max() < BOUND_DEG


@pytest.mark.parametrize("case", CASES)
def test_command_in_lines_an_initial_state_and_a_negative_gain(case: str, reference: Any) -> None:
    """Rows far apart joined by lines; k = -0.8, a bias and a start off rest in motion."""
    if case == "command_quantization":
        pytest.skip("the reference rounds rows only; test_a_ramp_is_rounded has the lines")
    effects = CASES[case]
    time_s = np.array([0.0, 0.03, 0.13, 0.17, 0.55, 0.6, 0.9])
    rows = time_s, np.array([0.0, 15.0, 15.0, -8.0, 10.0, 9.0, -10.0])
    samples = np.arange(0.0, 1.0, 0.0017)
    model = reference(-0.8, T, XI, 1.5, 4.0, 50.0, linear=True, effects=effects)
    truth = model.solve(*rows, samples)
    own = {"k": -0.8, "bias": 1.5, "initial_angle": 4.0, "initial_speed": 50.0}
    error = np.abs(simulated(effects, rows, samples, linear=True, **own) - truth)
    print(f"{case}: {error.max():.2e} deg")
    assert error.max() < BOUND_DEG


@pytest.mark.parametrize("xi", [0.05, 0.999999999, 1.0, 3.0, 15.0])
def test_linear_core_at_any_damping(xi: float, reference: Any) -> None:
    samples = np.arange(0.0, 0.8, 0.0013)
    truth = reference(1.0, T, xi).solve(*steps(), samples)
    error = np.abs(simulated({}, steps(), samples, xi=xi) - truth)
    print(f"xi = {xi}: {error.max():.2e} deg")
    assert error.max() < BOUND_DEG


def test_a_ramp_is_rounded(reference: Any) -> None:
    """Lines in steps of 1.7 deg: the same as a command held from riser to riser."""
    time_s, ramp = np.array([0.0, 0.1, 0.5, 0.7]), np.array([0.0, 0.0, 20.0, -5.0])
    samples = np.arange(0.0, 0.9, 0.0017)
    effects = {"command_quantization": {"step": 1.7}}
    angle = simulated(effects, (time_s, ramp), samples, linear=True)
    fine = np.linspace(0.0, 0.7, 7_000_001)
    levels = 1.7 * np.floor(np.interp(fine, time_s, ramp) / 1.7 + 0.5)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(levels)) + 1])
    truth = reference(1.0, T, XI).solve(fine[edges], levels[edges], samples)
    assert np.abs(angle - truth).max() < BOUND_DEG
