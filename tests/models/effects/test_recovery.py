"""Each effect's parameters are recovered from data that other means integrated.

Truth: the values in TRUTHS, integrated by scipy (support/reference.py) or, where that takes
minutes, by the plant at a sixteenth of the step, which test_plant_reference.py holds to scipy. An
effect without an entry is held to its own first start.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.plants import effect_of, plant, with_values

from servosight.identify.fit import identify
from servosight.models.core import Estimate, Recording, Signals
from servosight.models.effects import GuessFeatures, catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Stimulus
from servosight.models.plant.kernel._linear_core import STEP_SHARE

NOISE_DEG = 0.03

ALL = list(catalogue())


@dataclass(frozen=True)
class Truth:
    """A servo whose effect shows plainly, and the amplitude at which it does."""

    values: dict[str, float]
    T: float = 0.02
    xi: float = 0.6
    bias: float = 0.4
    amplitude_deg: float = 20.0
    independent: bool = True
    weight: float = 0.0
    """Cosine of a gravity load beside it [deg], known from another measurement."""


TRUTHS: dict[str, Truth] = {
    "dead_time": Truth({"delay": 0.0137}),
    "rate_limit": Truth({"rate": 220.0}),
    "motion_profile": Truth({"rate": 200.0, "acceleration": 8000.0}, independent=False),
    "velocity_feedforward": Truth({"lead": 0.012}),
    "integral_action": Truth({"rate": 12.0, "lag": 0.01}),
    "limited_integral": Truth({"rate": 12.0, "lag": 0.01, "limit": 1.0}),
    "dead_zone": Truth({"half_width": 1.3}),
    "dead_band": Truth({"half_width": 1.3}, independent=False),
    "torque_saturation": Truth({"limit": 6.0}),
    "coulomb_friction": Truth({"level": 1.2}),
    # Without a load it shows where a lively servo brakes against itself.
    "load_dependent_friction": Truth({"ratio": 0.55}, T=0.06, xi=0.38, amplitude_deg=30.0),
    # Without a load it is friction by the motor's torque.
    "directional_friction": Truth(
        {"motor": 0.3, "outer": 0.15, "back_emf": 0.015},
        weight=20.0,
        amplitude_deg=80.0,
        independent=False,
    ),
    "load_dependent_stribeck": Truth(
        {"excess": 0.3, "speed": 60.0, "back_emf": 0.015},
        weight=20.0,
        amplitude_deg=80.0,
        independent=False,
    ),
    # Its sine looks like a spring; the cosine bends only over a wide motion.
    "gravity_load": Truth({"sine": 3.0, "cosine": 24.0}, bias=24.0, amplitude_deg=30.0),
    "flexible_shaft": Truth({"frequency": 11.0, "damping": 0.08, "inertia_ratio": 0.35}),
    "backlash": Truth({"gap": 2.0}),
    "command_quantization": Truth({"step": 0.83}, independent=False),
    "asymmetric_gain": Truth({"ratio": 0.6}, independent=False),
    "speed_limit": Truth({"stall": 12.0, "no_load_speed": 260.0}, independent=False),
    "current_limit": Truth({"limit": 3.0, "back_emf": 0.01}, independent=False),
    "stribeck_friction": Truth({"level": 0.6, "excess": 0.9, "speed": 20.0}, independent=False),
    "presliding": Truth({"level": 1.2, "stiffness": 8.0}, independent=False),
    "quadratic_drag": Truth({"coefficient": 7e-5}, independent=False),
    "hinge_hardening": Truth({"cubic": 1.5e-3}, independent=False),
    "cogging": Truth({"amplitude": 0.9, "period": 6.3, "phase": 2.9}, independent=False),
    "supply_sag": Truth({"sag": 0.03, "time": 0.15}, independent=False),
    "linkage_geometry": Truth({"horn": 1.15, "offset": -18.0}, independent=False),
    "sensor_nonlinearity": Truth(
        {"amplitude": 1.1, "period": 24.0, "phase": -3.0}, independent=False
    ),
    "feedback_backlash": Truth({"gap": 1.4}, independent=False),
    "known_disturbance": Truth({"gain": 0.15}, independent=False),
}


def truth_of(name: str) -> Truth:
    effect = effect_of(name)
    names = [parameter.name for parameter in effect.parameters]
    start = effect.starts(GuessFeatures(1.0, 20.0, 400.0, 20.0, 0.02))[0]
    return TRUTHS.get(name) or Truth(dict(zip(names, start, strict=True)))


@cache
def synthetic(name: str, reference: Any) -> Recording:
    """12 s of steps, chirp, triangles and multisine at 120 Hz with 0.03 deg of noise."""
    truth = truth_of(name)
    command = standard(12.0, truth.amplitude_deg, seed=3, rate_hz=50.0)
    time_s = 0.004 + np.arange(1430) / 120.0
    signals = None
    if effect_of(name).needs_disturbance:
        rows_s = np.arange(0.0, 12.0, 0.85)
        signals = Signals(rows_s, {"disturbance_N": 20.0 * (np.arange(rows_s.size) % 3 - 1.0)})
    rows = command.time_s, command.command_deg
    blank = Recording(name, *rows, time_s, 0.0 * time_s, signals=signals)
    start = truth.bias if name != "gravity_load" else 0.0
    if name in TRUTHS and truth.independent:
        angle = reference(
            1.02, truth.T, truth.xi, truth.bias, start, effects={name: truth.values}
        ).solve(command.time_s, command.command_deg, time_s)
    else:
        row = with_values(name, tuple(truth.values.values()))
        row[:5] = 1.02, truth.T, truth.xi, truth.bias, start
        row[plant().index("gravity_load.cosine")] += truth.weight
        angle = plant().simulate(
            row,
            Stimulus.of(blank),
            STEP_SHARE * truth.T / 16,
        )
    noise = np.random.default_rng(7).normal(0.0, NOISE_DEG, time_s.size)
    return replace(blank, angle_deg=angle + noise)


def assert_recovered(name: str, parameters: dict[str, Estimate]) -> None:
    """Each parameter within the larger of 3 sigma and 5 % of its truth."""
    truth = truth_of(name)
    wanted = {f"{name}.{key}": value for key, value in truth.values.items()}
    wanted |= {"k": 1.02, "T": truth.T, "xi": truth.xi}
    for key, value in wanted.items():
        found = parameters[key]
        bound = max(3.0 * (found.sigma or 0.0), 0.05 * abs(value))
        print(
            f"{key}: truth {value:g}, found {found.value:.5g} +- {found.sigma}, bound {bound:.2g}"
        )
        assert abs(found.value - value) <= bound, key


@pytest.mark.parametrize("name", ALL)
def test_it_is_recovered_from_a_finer_integration(name: str, reference: Any) -> None:
    """And nothing but the noise remains: rmse within 3 % of 0.03 deg (1430 samples: 1.9 %)."""
    recording = synthetic(name, reference)
    beside = ["gravity_load"] if truth_of(name).weight else []
    found = identify([recording], [name, *beside], catalogue=catalogue(), method="gradient")
    assert_recovered(name, dict(found.actuator.parameters))
    assert found.rmse_deg == pytest.approx(NOISE_DEG, rel=0.06)
