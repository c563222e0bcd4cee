"""Population searches as estimators: genetic algorithm, particle swarm, and the combination.

An algorithm is one operator that takes a generation to the next; the paper's sections are cited
where each stands. Nothing else differs between the three.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.identify.search._combination import combine
from servosight.identify.search._estimator import half_squares
from servosight.identify.search._genetic import breed
from servosight.identify.search._population_state import Box, Operator, Settings, first_flock
from servosight.identify.search._swarm import fly
from servosight.models.core import Array


class Population:
    """An estimator that applies ``operator`` after each generation.

    ``low`` and ``high`` (genes,) bound the search; ``seeds`` (rows of points) join the first
    generation. The same ``seed`` gives the same run.
    """

    def __init__(
        self,
        operator: Operator,
        low: Array,
        high: Array,
        seed: int,
        seeds: Array | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.operator = operator
        self.box = Box(low, high)
        self.settings = settings or Settings()
        self.rng = np.random.default_rng(seed)
        self.stopped = ""
        self._quiet = 0
        self.flock = first_flock(self.box, self.settings.population, self.rng, seeds)

    def ask(self) -> Array:
        """The members' positions."""
        return self.flock.position

    def tell(self, points: Array, residuals: Array) -> None:
        """Remember the best, stop where nothing improves, else make the next generation."""
        before = float(self.flock.best_cost.min())
        flock = self.flock.remembering(half_squares(residuals))
        improved = float(flock.best_cost.min()) < before * (1.0 - self.settings.tolerance)
        self._quiet = 0 if improved else self._quiet + 1
        if self._quiet >= self.settings.patience:
            self.stopped = f"converged: no better point in {self._quiet} generations"
        else:
            flock = self.operator(flock, self.box, self.settings, self.rng)
        self.flock = flock

    def lead(self, point: Array, cost: float) -> None:
        """Take over a better ``point`` (genes,) that was found elsewhere."""
        self.flock = self.flock.led_by(point, cost)


OPERATORS: Mapping[str, Operator] = {"combination": combine, "ga": breed, "pso": fly}
"""The population searches by name."""
