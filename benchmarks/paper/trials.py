"""Search problems on which the paper's algorithms, and others, are counted.

Each is residuals over a box and the cost below which the search has found what it looked for. Two
are textbook functions, written so that half their residuals' squares is the function; two are fits
of an actuator.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from servosight.identify.problem import Problem, coordinate_scale
from servosight.identify.search import LevenbergMarquardt, Residuals, drive
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import LinearServo

WITHIN = 1.01
"""A fit has converged within 1 % of the least-squares cost."""


@dataclass(frozen=True)
class SearchProblem:
    """Residuals (batch, samples) of points (batch, coordinates) in a box, and the ``goal``.

    ``scale`` (coordinates,): a meaningful change of each coordinate, for difference quotients.
    """

    name: str
    residuals: Residuals
    low: Array
    high: Array
    goal: float
    scale: Array


def rosenbrock(half_width: float = 2.048, goal: float = 1e-3) -> SearchProblem:
    """100 (y - x^2)^2 + (1 - x)^2, the paper's figure 10; one minimum at the end of a bent valley.

    Rosenbrock, The Computer Journal 3(3), 1960; +-2.048 after De Jong (1975).
    """

    def residuals(points: Array) -> Array:
        x, y = points.T
        return np.asarray(np.sqrt(2.0) * np.stack([10.0 * (y - x**2), 1.0 - x], axis=1))

    edge = np.full(2, half_width)
    return SearchProblem("rosenbrock", residuals, -edge, edge, goal, np.ones(2))


def rastrigin(goal: float = 1e-3) -> SearchProblem:
    """Two genes of 10 + x^2 - 10 cos(2 pi x) within +-5.12: a hundred minima (Rastrigin 1974)."""

    def residuals(points: Array) -> Array:
        each = 10.0 + points**2 - 10.0 * np.cos(2.0 * np.pi * points)
        return np.asarray(np.sqrt(2.0 * np.maximum(each, 0.0)))

    edge = np.full(2, 5.12)
    return SearchProblem("rastrigin", residuals, -edge, edge, goal, np.ones(2))


def linear_fit(seed: int = 3) -> SearchProblem:
    """k, T, xi and bias of a noisy record of 8 s at 120 Hz, from wide bounds.

    k 0.1 to 3, T 1 to 500 ms and xi 0.05 to 5 (searched by their logarithms), bias +-20 deg.
    """
    plant = Plant.of(catalogue())
    command = standard(8.0, 20.0, seed=5)
    time_s = 0.004 + np.arange(950) / 120.0
    stimulus = Stimulus(command.time_s, command.command_deg, False, time_s, np.ones(1))
    columns = [plant.index(name) for name in ("k", "T", "xi", "bias")]

    def simulated(points: Array, step_s: float | None = None) -> Array:
        rows = np.tile(np.array(plant.layout.neutral_row()), (len(points), 1))
        rows[:, columns] = points
        rows[:, columns[1:3]] = np.exp(points[:, 1:3])
        return plant.simulate(rows, stimulus, step_s)

    truth = np.array([1.027, np.log(0.02), np.log(0.6), 0.5])
    noise = np.random.default_rng(seed).normal(0.0, 0.03, time_s.size)
    measured = simulated(truth[None, :], 1e-4)[0] + noise

    def residuals(points: Array) -> Array:
        error = np.clip(measured - simulated(points), -1e6, 1e6)
        return np.asarray(np.nan_to_num(error, nan=1e6))

    low = np.array([0.1, np.log(1e-3), np.log(0.05), -20.0])
    high = np.array([3.0, np.log(0.5), np.log(5.0), 20.0])
    return _converged(SearchProblem("linear fit", residuals, low, high, 0.0, np.ones(4)), truth)


@dataclass(frozen=True)
class LocalMinima:
    """A twin with backlash and friction, and a fit of both that starts from nothing.

    The twin moves by MuJoCo's own physics. The search knows no guesses: k 0.3 to 2, T 2 to 300 ms,
    xi 0.05 to 5, gap and friction 0 to 12 deg, bias and initial angle +-10 deg. Too much play looks
    like friction and a short T like either, so there are minima besides.
    """

    seed: int = 4
    gap_deg: float = 2.0
    level_deg: float = 1.5

    @cached_property
    def recording(self) -> Recording:
        """6 s at 120 Hz with 0.03 deg of noise."""
        from servosight.sim.run import angle_recording, run

        scenario = Scenario(
            seed=self.seed,
            duration_s=6.0,
            servo=LinearServo(1.0, 0.025, 0.6, 0.3),
            effects={
                "backlash": {"gap": self.gap_deg},
                "coulomb_friction": {"level": self.level_deg},
            },
        )
        moved = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
        return angle_recording(moved, scenario.camera, scenario.noise_deg, self.seed)

    def trial(self) -> SearchProblem:
        """The fit; its goal is 5 % above the cost that descends from the truth itself."""
        problem = Problem.of([self.recording], catalogue(), ["backlash", "coulomb_friction"])
        truth = {
            "k": 1.0,
            "T": 0.025,
            "xi": 0.6,
            "backlash.gap": self.gap_deg,
            "coulomb_friction.level": self.level_deg,
            "bias": 0.3,
            "initial_angle": float(self.recording.angle_deg[0]),
            "initial_speed": 0.0,
        }
        box = {
            "k": (0.3, 2.0),
            "T": (0.002, 0.3),
            "xi": (0.05, 5.0),
            "backlash.gap": (0.0, 12.0),
            "coulomb_friction.level": (0.0, 12.0),
            "bias": (-10.0, 10.0),
            "initial_angle": (-10.0, 10.0),
            "initial_speed": (-100.0, 100.0),
        }
        low, high = (
            np.array([c.to_search(box[c.name][side]) for c in problem.coordinates])
            for side in (0, 1)
        )
        start = np.array([c.to_search(truth[c.name]) for c in problem.coordinates])
        scale = coordinate_scale(problem, start)
        blank = SearchProblem("backlash and friction", problem.residuals, low, high, 0.0, scale)
        return _converged(blank, start, 1.05)


def _converged(trial: SearchProblem, truth: Array, within: float = WITHIN) -> SearchProblem:
    """The trial with its goal: ``within`` times the cost at the bottom of the truth's own basin."""
    descent = LevenbergMarquardt(truth, trial.low, trial.high, trial.scale)
    best = drive(descent, trial.residuals, 2_000)
    return replace(trial, goal=within * best.cost)
