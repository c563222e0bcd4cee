"""Population searches as estimators: genetic algorithm, particle swarm, and the combination.

An algorithm is one operator that leads from a generation to the next; each cites its section of the
paper. Nothing else differs between the three.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.identify.search._estimator import Stop, StopReason, half_squares
from servosight.identify.search._ga import ga_step
from servosight.identify.search._hybrid import hybrid_step
from servosight.identify.search._population_state import (
    Bounds,
    Operator,
    PopulationOptions,
    initial_state,
)
from servosight.identify.search._pso import pso_step
from servosight.models.core import Array


class Population:
    """An estimator that applies ``operator`` after each generation.

    ``low`` and ``high`` (coordinates,) bound the search; ``guesses`` (points, coordinates) join the
    first generation. The same ``seed`` gives the same run.
    """

    def __init__(
        self,
        operator: Operator,
        low: Array,
        high: Array,
        seed: int,
        guesses: Array | None = None,
        options: PopulationOptions | None = None,
    ) -> None:
        self.operator = operator
        self.bounds = Bounds(low, high)
        self.options = options or PopulationOptions()
        self.rng = np.random.default_rng(seed)
        self.stopped: Stop | None = None
        self._without_gain = 0
        self.state = initial_state(self.bounds, self.options.population, self.rng, guesses)

    def ask(self) -> Array:
        """The members' positions."""
        return self.state.position

    def tell(self, points: Array, residuals: Array) -> None:
        """Keep the best, stop where nothing improves, else make the next generation."""
        before = float(self.state.best_cost.min())
        state = self.state.with_cost(half_squares(residuals))
        improved = float(state.best_cost.min()) < before * (1.0 - self.options.tolerance)
        self._without_gain = 0 if improved else self._without_gain + 1
        if self._without_gain >= self.options.patience:
            words = f"converged: no better point in {self._without_gain} generations"
            self.stopped = Stop(StopReason.CONVERGED, words)
        else:
            state = self.operator(state, self.bounds, self.options, self.rng)
        self.state = state

    def take(self, point: Array, cost: float) -> None:
        """Take over a better ``point`` (coordinates,) that was found elsewhere."""
        self.state = self.state.with_best(point, cost)


OPERATORS: Mapping[str, Operator] = {"combination": hybrid_step, "ga": ga_step, "pso": pso_step}
"""The operators by name."""
