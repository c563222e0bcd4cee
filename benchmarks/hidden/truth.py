"""Who makes the truth: the MuJoCo twin, plain fixed steps, or the fitted equation itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.models.plant import Plant, Stimulus
from servosight.scenarios.draws import UNCATALOGUED_DRAWS
from servosight.scenarios.scenario import Effects
from servosight.scenarios.settings import LinearServo
from servosight.sim.bench import Trajectory
from servosight.sim.effects import HIDDEN_EFFECTS
from servosight.sim.run import SETTLE, run

from .plant import KEPT, STEP_S, Physics, march

Truth = Callable[[LinearServo, Effects, Excitation], Trajectory]

GRID_S = KEPT * STEP_S

OUTSIDE: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "command_filter": {"time": (0.01, 0.05)},
    "vibration": {"amplitude": (0.1, 2.0), "frequency": (0.7, 6.0)},
    "gust": {"amplitude": (0.3, 2.0), "time": (0.05, 0.4), "seed": (0.0, 1e6)},
    "warming": {"fade": (0.05, 0.3), "time": (3.0, 10.0)},
    "creep": {"share": (0.05, 0.3), "time": (0.2, 2.0)},
}
"""What no catalogue names, beside the twin's of that kind (scenarios/draws.py): a filter in
the firmware, somebody else's machine on the bench, wind, a motor that warms up, a
surface that creeps. Ranges of the parameters, in seconds, degrees, Hz and their quotients."""


def fixed_steps(servo: LinearServo, effects: Effects, excitation: Excitation) -> Trajectory:
    """:mod:`hidden_plant` under a held command; the same settling as the twin's."""
    values = {f"{name}_{key}": x for name, group in effects.items() for key, x in group.items()}
    numbers = {"k": servo.k, "T": servo.T, "xi": servo.xi, "bias": servo.bias, **values}
    physics = Physics(**{key: float(x) for key, x in numbers.items() if key in Physics._fields})
    start, duration_s = float(excitation.time_s[0]), excitation.duration_s
    kept = math.ceil(duration_s / GRID_S - 1e-6)
    settle = math.ceil(SETTLE * servo.T / GRID_S)
    instants: Array = start + STEP_S * np.arange(-settle * KEPT, kept * KEPT + 1.0)
    edges = np.append(instants, instants[-1] + STEP_S) - 0.5 * STEP_S
    motor, surface = march(
        physics, _sent(physics, excitation, edges), _wind(effects, instants), KEPT
    )
    return _trajectory(excitation, motor[settle:], surface[settle:])


def equation(servo: LinearServo, effects: Effects, excitation: Excitation) -> Trajectory:
    """The plant equation that is fitted; the same settling as the twin's."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    values = {f"{name}.{key}": x for name, group in effects.items() for key, x in group.items()}
    for name, value in {"k": servo.k, "T": servo.T, "xi": servo.xi, **values}.items():
        row[plant.index(name)] = value
    row[plant.index("bias")] = servo.bias
    row[plant.index("initial_angle")] = servo.k * excitation.command_deg[0] + servo.bias
    settle = math.ceil(SETTLE * servo.T / GRID_S)
    time_s = _grid(excitation)
    time_s = np.concatenate([time_s[0] + GRID_S * np.arange(-settle, 0), time_s])
    command = Recording("truth", excitation.time_s, excitation.command_deg, time_s, time_s)
    angle = plant.simulate(row, Stimulus.of(command), step_s=servo.T / 20.0)[settle:]
    return _trajectory(excitation, angle, angle)


def twin(servo: LinearServo, effects: Effects, excitation: Excitation) -> Trajectory:
    """The MuJoCo twin."""
    return run(servo.bench(), effects, excitation)


TRUTHS: Mapping[str, Truth] = {"fixed steps": fixed_steps, "equation": equation, "twin": twin}


def known(truth: str) -> list[str]:
    """The catalogued effects that a truth can hide."""
    effects = catalogue()
    if truth == "equation":
        return list(effects)
    if truth == "twin":
        return [name for name in effects if name in HIDDEN_EFFECTS]
    fields = set(Physics._fields)
    return [
        name
        for name, effect in effects.items()
        if all(f"{name}_{parameter.name}" in fields for parameter in effect.parameters)
    ]


def outside(truth: str) -> Mapping[str, Mapping[str, tuple[float, float]]]:
    """Ranges of what a truth can hide and no catalogue names."""
    found: Mapping[str, Mapping[str, tuple[float, float]]] = {
        "twin": {name: draw.parameters for name, draw in UNCATALOGUED_DRAWS.items()},
        "fixed steps": OUTSIDE,
    }.get(truth, {})
    return {name: ranges for name, ranges in found.items() if name not in catalogue()}


def _sent(physics: Physics, excitation: Excitation, edges_s: Array) -> Array:
    """The held command, quantized and late, as means between ``edges_s``."""
    value = np.asarray(excitation.command_deg, dtype=np.float64)
    step = physics.command_quantization_step
    if step > 0.0:
        value = step * np.floor(value / step + 0.5)
    rows_s = excitation.time_s + physics.dead_time_delay
    times = np.concatenate([[min(edges_s[0], rows_s[0]) - 1.0], rows_s, [edges_s[-1] + 1.0]])
    # Between two rows the command stands still, so its integral is a line.
    area = np.concatenate([[0.0], np.cumsum(np.append(value[0], value) * np.diff(times))])
    return np.asarray(np.diff(np.interp(edges_s, times, area)) / np.diff(edges_s))


def _wind(effects: Effects, time_s: Array) -> Array:
    """A torque that has nothing to do with the command [deg]: a tone and filtered noise."""
    torque = np.zeros_like(time_s)
    if tone := effects.get("vibration"):
        torque += tone["amplitude"] * np.sin(2.0 * np.pi * tone["frequency"] * time_s)
    if gust := effects.get("gust"):
        rng = np.random.default_rng(int(gust["seed"]))
        knots = np.arange(time_s[0], time_s[-1] + gust["time"], 0.5 * gust["time"])
        torque += gust["amplitude"] * np.interp(time_s, knots, rng.normal(size=knots.size))
    return torque


def _grid(excitation: Excitation) -> Array:
    count = math.ceil(excitation.duration_s / GRID_S - 1e-6)
    return np.asarray(float(excitation.time_s[0]) + GRID_S * np.arange(count + 1.0))


def _trajectory(excitation: Excitation, motor_deg: Array, surface_deg: Array) -> Trajectory:
    time_s = _grid(excitation)
    return Trajectory(time_s, motor_deg, surface_deg, excitation.at(time_s), excitation)
