"""A population that searches and a descent that finishes, each hearing of the other.

The population finds the basin, which is what it is good at; Gauss-Newton goes to its bottom in a
few dozen simulations, where a population takes hundreds. A local minimum is a start like another:
the population, led by what was polished, goes on looking for anything better.
"""

from __future__ import annotations

import numpy as np

from servosight.identify.search._levenberg_marquardt import GaussNewton
from servosight.identify.search._population import Population
from servosight.models.core import Array

FIRST = 2
"""Generations before the first descent: one hypercube, and one step towards its best."""
PATIENCE = 5
"""Generations that must find nothing better than the last descent before the search ends."""


class Polished:
    """``population``, with descents from its best. ``scale`` (genes,) is that of GaussNewton.

    Every simulation counts as an evaluation of the run, those for difference quotients included.
    """

    def __init__(
        self, population: Population, scale: Array, first: int = FIRST, patience: int = PATIENCE
    ) -> None:
        self.population = population
        self.scale = scale
        self.patience = patience
        self.stopped = ""
        self._best = np.inf
        self._wait = first
        self._quiet = 0
        self._descent: GaussNewton | None = None

    def ask(self) -> Array:
        """The population's members, or what the descent wants to know."""
        return (self._descent or self.population).ask()

    def tell(self, points: Array, residuals: Array) -> None:
        """Pass on to whoever asked; change over where a descent is due or done."""
        if self._descent is None:
            self._search(points, residuals)
        else:
            self._descend(self._descent, points, residuals)

    def _search(self, points: Array, residuals: Array) -> None:
        self.population.tell(points, residuals)
        self._wait -= 1
        better = self.population.flock.best_cost.min() < self._best * (1.0 - 1e-6)
        self._quiet = 0 if better else self._quiet + 1
        if better and self._wait <= 0:
            box = self.population.box
            leader = self.population.flock.leader
            self._descent = GaussNewton(leader, box.low, box.high, self.scale)
        elif self.population.stopped or self._quiet >= self.patience:
            self.stopped = f"converged: {self._quiet} generations found nothing better to polish"

    def _descend(self, descent: GaussNewton, points: Array, residuals: Array) -> None:
        descent.tell(points, residuals)
        if descent.stopped:
            self._best = descent.cost
            self.population.lead(descent.point, descent.cost)
            self._descent = None
