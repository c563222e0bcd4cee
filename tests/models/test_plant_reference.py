"""The compiled plant against the same equation solved by scipy to 1e-10 (conftest.py).

Bound: 0.002 deg at the default step, at T = 7.8 ms and xi = 0.55, on steps of 20 deg and a chirp to
12 Hz. The smallest noise a fit is expected to reach is ten times that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.models.plant import Plant, Stimulus
from servosight.models.registry import catalogue

Array = NDArray[np.float64]

BOUND_DEG = 0.002
T, XI = 0.0078, 0.55

CASES: dict[str, dict[str, dict[str, float]]] = {
    "linear": {},
    "dead_time": {"dead_time": {"delay": 0.00777}},
    "rate_limit": {"rate_limit": {"rate": 150.0}},
    "dead_zone": {"dead_zone": {"half_width": 1.3}},
    "torque_saturation": {"torque_saturation": {"limit": 4.0}},
    "coulomb_friction": {"coulomb_friction": {"level": 1.2}},
    "load_dependent_friction": {"load_dependent_friction": {"ratio": 0.4}},
    "gravity_load": {"gravity_load": {"sine": 5.0, "cosine": 12.0}},
    "flexible_shaft": {
        "flexible_shaft": {"frequency": 12.0, "damping": 0.08, "inertia_ratio": 0.3}
    },
    "stiff shaft": {"flexible_shaft": {"frequency": 60.0, "damping": 0.02, "inertia_ratio": 0.6}},
    "backlash": {"backlash": {"gap": 2.0}},
    "both frictions": {
        "coulomb_friction": {"level": 0.6},
        "load_dependent_friction": {"ratio": 0.3},
    },
    "friction by load under a weight": {
        "load_dependent_friction": {"ratio": 0.3},
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
