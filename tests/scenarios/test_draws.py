"""Hidden effects are plain to see: the linear model misses them by ten times the noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus
from servosight.scenarios.draws import DRAWS, SHOWN_ALONE
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings, LinearServo
from servosight.sim.run import run

# The weakest corner of each range: the end of each parameter, T and xi at which the misfit is
# least, found by trying all corners.
WEAKEST = {
    "dead_time": ({"delay": 0}, 1, 1),
    "command_quantization": ({"step": 0}, 1, 1),
    "rate_limit": ({"rate": 1}, 1, 1),
    "motion_profile": ({"rate": 1, "acceleration": 1}, 1, 1),
    "velocity_feedforward": ({"lead": 0}, 0, 1),
    "asymmetric_gain": ({"ratio": 1}, 0, 1),
    "dead_zone": ({"half_width": 0}, 1, 1),
    "torque_saturation": ({"limit": 1}, 0, 1),
    "speed_limit": ({"stall": 1, "no_load_speed": 1}, 1, 1),
    "current_limit": ({"limit": 1, "back_emf": 1}, 0, 1),
    "coulomb_friction": ({"level": 0}, 1, 1),
    "stribeck_friction": ({"level": 0, "excess": 0, "speed": 0}, 1, 1),
    "load_dependent_friction": ({"ratio": 0}, 0, 1),
    "presliding": ({"level": 0, "stiffness": 0}, 1, 1),
    "quadratic_drag": ({"coefficient": 0}, 1, 1),
    "gravity_load": ({"sine": 1, "cosine": 0}, 1, 1),
    "hinge_hardening": ({"cubic": 0}, 1, 1),
    "cogging": ({"amplitude": 0, "period": 0, "phase": 1}, 1, 1),
    "supply_sag": ({"sag": 0, "time": 1}, 0, 1),
    "flexible_shaft": ({"frequency": 1, "damping": 1, "inertia_ratio": 1}, 1, 1),
    "backlash": ({"gap": 0}, 1, 1),
    "linkage_geometry": ({"horn": 0, "offset": 0}, 1, 1),
    "sensor_nonlinearity": ({"amplitude": 0, "period": 1, "phase": 0}, 1, 1),
    "feedback_backlash": ({"gap": 0}, 0, 1),
}


@pytest.mark.parametrize("effect", SHOWN_ALONE)
def test_the_weakest_draw_misfits_by_ten_times_the_noise(effect: str) -> None:
    draw = DRAWS[effect]
    ends, slow, damped = WEAKEST[effect]
    values = {name: draw.parameters[name][end] for name, end in ends.items()}
    servo = LinearServo(1.0, draw.T[slow], draw.xi[damped], values.get(draw.trimmed, 0.0))
    scenario = Scenario(
        duration_s=12.0,
        servo=servo,
        motion=CommandSettings(amplitude_deg=draw.amplitude_deg),
        effects={effect: values},
    )
    command = scenario.excitation()
    twin = run(servo.bench(), scenario.effects, command)
    time_s = scenario.camera.frame_starts(scenario.duration_s)
    angle = twin.angle_at(time_s)

    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    free = [plant.index(name) for name in ("k", "T", "xi", "bias", "initial_angle")]
    asked = Stimulus(command.time_s, command.command_deg, False, time_s, np.ones(1))

    def residual(x: np.ndarray) -> np.ndarray:
        row[free] = x
        return plant.simulate(row, asked) - angle

    fit = least_squares(
        residual,
        [1.0, servo.T, servo.xi, angle[0], angle[0]],
        bounds=([0.1, 1e-3, 0.05, -90, -90], [3.0, 1.0, 10.0, 90, 90]),
        x_scale=[1.0, servo.T, servo.xi, 1.0, 1.0],
        max_nfev=40,
    )
    assert float(np.sqrt(np.mean(fit.fun**2))) >= 0.3
