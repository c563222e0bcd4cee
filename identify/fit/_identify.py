"""From recordings to a model with its uncertainty: the search methods, and what they return."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from servosight.identify.fit._fit import Fit, coordinate_scale, fit_effects, polish
from servosight.identify.problem import (
    TOLERANCE_SHARE,
    Problem,
    Standpoint,
    effect_starts,
    joint_noise_deg,
    linear_start,
    search_box,
    thinned,
)
from servosight.identify.search import OPERATORS, Polished, Population, drive
from servosight.identify.uncertainty import estimates, own_estimates
from servosight.models.core import Actuator, Array, Estimate, Recording, views
from servosight.models.effects import Effect

SEARCH_BUDGET = 6_000


@dataclass(frozen=True)
class Identification:
    """What ``identify`` returns and JSON carries."""

    actuator: Actuator
    biases: tuple[Estimate, ...]
    rmse_deg: float
    noise_deg: float
    floor_deg: float
    samples: int
    method: str
    seconds: float
    stopped: str
    warnings: tuple[str, ...] = ()
    evaluations: int = 0
    history: Array = field(default_factory=lambda: np.empty(0))

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md); ``bias`` is a list where there are several recordings."""
        return {
            "schema": 1,
            "parameters": parameters_json(self.actuator.parameters, self.biases),
            "rmse_deg": self.rmse_deg,
            "noise_deg": self.noise_deg,
            "floor_deg": self.floor_deg,
            "samples": self.samples,
            "method": self.method,
            "seconds": self.seconds,
            "stopped": self.stopped,
            "warnings": list(self.warnings),
        }


def parameters_json(
    parameters: Mapping[str, Estimate], biases: Sequence[Estimate]
) -> dict[str, Any]:
    """Parameters as JSON, ``bias`` as one estimate or, for several recordings, as a list."""
    table: dict[str, Any] = {name: one.to_json() for name, one in parameters.items()}
    listed = [bias.to_json() for bias in biases]
    table["bias"] = listed[0] if len(listed) == 1 else listed
    return table


def floor_deg(recordings: Sequence[Recording], noise: float, tolerance: float | None) -> float:
    """hypot(noise, tolerance) [deg]; the tolerance is 0.05 % of the moved range by default."""
    if tolerance is None:
        tolerance = TOLERANCE_SHARE * max(recording.moved_range_deg for recording in recordings)
    return float(np.hypot(noise, tolerance))


def identify(
    recordings: Sequence[Recording],
    effects: Sequence[str],
    *,
    catalogue: Mapping[str, Effect],
    method: str = "combination",
    seed: int = 0,
    tolerance: float | None = None,
) -> Identification:
    """Fit the linear core and ``effects`` to recordings jointly, a horn's angle among them.

    ``method`` is a key of :data:`METHODS`. Every method is polished by Gauss-Newton.
    """
    began = time.perf_counter()
    whole = views(recordings)
    scored, notes = thinned(whole)
    problem = Problem.of(scored, catalogue, effects)
    fit, history = METHODS[method](problem, seed)
    table, warnings = estimates(problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
    biases = own_estimates(problem, fit.outcome.point, fit.jacobian, fit.outcome.cost, "bias")
    noise = joint_noise_deg(tuple(whole))
    return Identification(
        Actuator(
            {**table, "bias": biases[0]},
            tuple(effects),
            {"fitted_on": [recording.name for recording in recordings], "method": method},
        ),
        biases,
        fit.rmse_deg,
        noise,
        floor_deg(recordings, noise, tolerance),
        int(sum(mask.sum() for mask in problem.masks)),
        method,
        time.perf_counter() - began,
        fit.outcome.stopped,
        (*notes, *warnings),
        fit.outcome.evaluations,
        history,
    )


def _by_gradient(problem: Problem, seed: int) -> tuple[Fit, Array]:
    fit = fit_effects(problem)
    return fit, fit.outcome.history


def _by_population(name: str, problem: Problem, seed: int) -> tuple[Fit, Array]:
    """A population and its descents search the box around the linear fit; the best is polished."""
    linear = Problem(problem.recordings, problem.plant, (), problem.masks)
    start = Standpoint(linear, linear_start(linear))
    low, high = search_box(problem, start)
    seeds = np.array(effect_starts(problem, start))
    population = Population(OPERATORS[name], low, high, seed, seeds)
    estimator = Polished(population, coordinate_scale(problem, seeds[0]))
    search = drive(estimator, problem.residuals, SEARCH_BUDGET)
    return polish(problem, [search.point]), search.history


METHODS: dict[str, Callable[[Problem, int], tuple[Fit, Array]]] = {
    **{name: functools.partial(_by_population, name) for name in OPERATORS},
    "gradient": _by_gradient,
}
"""Search methods by name."""
