"""The twin under a command that is known only as it comes: what stands behind a virtual servo."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from servosight.models.core import Array, InputError
from servosight.models.excitation import Excitation
from servosight.sim.assembled import longest_step_s, put_to_rest, with_effects
from servosight.sim.bench import GRID_S, BenchParameters, Trajectory
from servosight.sim.effects import TWIN_EFFECTS, HiddenEffect, Twin, resolve
from servosight.sim.stepping import Stepper

CAMERA_STEPS_PER_T = 400
"""Steps in a time constant T where a camera measures the angle. Eight times as many as a
simulation with an encoder's noise needs: where dry friction begins or ends within a step, the error
is in proportion to the step (rms 0.003 deg at 50, 0.0003 at 400), and a camera measures the angle
to 0.0015 deg."""
STOPS_WITHIN = 0.01
"""Share of a step without torque within which the speed falls to zero. Between the instants kept
the motion is interpolated by cubics, which would overshoot if it fell over the whole step."""
_BLOCK = 4096


class LiveTwin:
    """Moves from step to step and keeps what it did, so that a camera can look back at it.

    ``time_s`` counts from 0. Raises InputError for effects that change the command itself, such as
    a dead time: they need it ahead.
    """

    def __init__(self, bench: BenchParameters, effects: Mapping[str, Mapping[str, float]]) -> None:
        chosen = [(TWIN_EFFECTS[name], values) for name, values in resolve(effects).items()]
        for effect, _ in chosen:
            if not runs_live(effect):
                raise InputError(
                    f"{effect.id}: changes the command before the servo has it, expected an effect "
                    f"of the servo itself; choose another one, such as backlash"
                )
        effects_of = (effect for effect, _ in chosen)
        self._step_s = longest_step_s(bench.T, effects_of, CAMERA_STEPS_PER_T)
        assembly = with_effects(bench, chosen, self._step_s)
        self._twin, self._bench, self._chosen = Twin(assembly), bench, chosen
        self._surface = put_to_rest(self._twin, assembly, math.radians(bench.bias_deg))
        self._stepper = Stepper(self._twin, chosen)
        self.time_s = 0.0
        self._count = 0
        self._rows = np.empty((_BLOCK, 1 + 2 * 2))
        self._keep()

    def step(self, command_deg: float | None, dt: float) -> float:
        """Hold a command for ``dt`` s, or stand still without torque (None); the servo's angle.

        That is what its own sensor reports in units of the command, in deg.
        """
        if command_deg is None:
            self._stepper.speed[:] = 0.0
            self.time_s += STOPS_WITHIN * dt
            self._keep()
            self.time_s += (1.0 - STOPS_WITHIN) * dt
            self._keep()
        else:
            goal = math.radians(self._bench.gain * command_deg + self._bench.bias_deg)
            count = max(math.ceil(dt / self._step_s - 1e-9), 1)
            for _ in range(count):
                self._stepper.advance(goal, dt / count)
                self.time_s += dt / count
                self._keep()
        angle = math.degrees(float(self._stepper.position[self._twin.sensor]))
        return (angle - self._bench.bias_deg) / self._bench.gain

    def between(self, from_s: float, to_s: float) -> Trajectory:
        """What it did from one time to another, on a grid of 0.1 ms; before 0 it stood still."""
        rows = self._rows[: self._count]
        first = max(int(np.searchsorted(rows[:, 0], from_s)) - 3, 0)
        last = int(np.searchsorted(rows[:, 0], to_s)) + 3
        part = rows[first:last]
        points = max(math.ceil((to_s - from_s) / GRID_S), 1) + 1
        grid: Array = from_s + GRID_S * np.arange(points, dtype=np.float64)
        inside = np.clip(grid, part[0, 0], part[-1, 0])
        motor, surface = (
            np.asarray(CubicHermiteSpline(part[:, 0], part[:, a], part[:, a + 2])(inside))
            if len(part) > 1
            else np.full(points, part[0, a])
            for a in (1, 2)
        )
        for effect, values in self._chosen:
            surface = effect.output(surface, values)
        still = np.zeros(points)
        return Trajectory(grid, motor, surface, still, Excitation(grid[[0, -1]], still[:2]))

    def _keep(self) -> None:
        """Note time, angles of sensor and surface, and their speeds [s, deg, deg/s]."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        position, speed = self._stepper.position, self._stepper.speed
        sensor = self._twin.sensor
        self._rows[self._count] = (
            self.time_s,
            math.degrees(position[sensor]),
            math.degrees(sum(position[hinge] for hinge in self._surface)),
            math.degrees(speed[sensor]),
            math.degrees(sum(speed[hinge] for hinge in self._surface)),
        )
        self._count += 1


def runs_live(effect: HiddenEffect) -> bool:
    """Whether an effect leaves the command as it is."""
    return effect.command is HiddenEffect.__dataclass_fields__["command"].default
