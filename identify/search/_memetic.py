"""Memetic search: a population explores, and Levenberg-Marquardt descents from its best refine it.

The population finds the basin of the minimum; a descent reaches its bottom in a few dozen
simulations, where a population needs hundreds. A local minimum is a start like another: the
population takes over what a descent found, and goes on looking for anything better.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from servosight.identify.search._estimator import SearchSpace, Stop, StopReason
from servosight.identify.search._levenberg_marquardt import LevenbergMarquardt
from servosight.identify.search._population import OPERATORS, Population
from servosight.models.core import Array


@dataclass(frozen=True)
class MemeticOptions:
    """``first``: generations before the first descent (the hypercube, and one step from it).

    The search ends where ``patience`` generations find nothing better than the last descent.
    """

    first: int = 2
    patience: int = 5


class MemeticSearch:
    """``population`` with descents from its best; ``scale`` (coordinates,) is the descents'.

    Every simulation counts as an evaluation of the run, those for difference quotients included.
    """

    def __init__(
        self,
        population: Population,
        scale: Array,
        options: MemeticOptions = MemeticOptions(),
    ) -> None:
        self.population = population
        self.scale = scale
        self.options = options
        self.stopped: Stop | None = None
        self._best = np.inf
        self._wait = options.first
        self._without_gain = 0
        self._descent: LevenbergMarquardt | None = None

    def ask(self) -> Array:
        """The population's members, or the points that the descent needs."""
        return (self._descent or self.population).ask()

    def tell(self, points: Array, residuals: Array) -> None:
        """Pass on to the one that asked; change over where a descent is due or done."""
        if self._descent is None:
            self._explore(points, residuals)
        else:
            self._refine(self._descent, points, residuals)

    def _explore(self, points: Array, residuals: Array) -> None:
        self.population.tell(points, residuals)
        self._wait -= 1
        better = self.population.state.best_cost.min() < self._best * (1.0 - 1e-6)
        self._without_gain = 0 if better else self._without_gain + 1
        if better and self._wait <= 0:
            bounds = self.population.bounds
            best = self.population.state.best_point
            self._descent = LevenbergMarquardt(best, bounds.low, bounds.high, self.scale)
        elif self.population.stopped or self._without_gain >= self.options.patience:
            count = self._without_gain
            words = f"converged: {count} generations found no better point to refine"
            self.stopped = Stop(StopReason.CONVERGED, words)

    def _refine(self, descent: LevenbergMarquardt, points: Array, residuals: Array) -> None:
        descent.tell(points, residuals)
        if descent.stopped:
            self._best = descent.cost
            self.population.take(descent.point, descent.cost)
            self._descent = None


def memetic(name: str) -> Callable[[SearchSpace], MemeticSearch]:
    """Makes a memetic search with the operator of that name."""

    def make(space: SearchSpace) -> MemeticSearch:
        population = Population(OPERATORS[name], space.low, space.high, space.seed, space.guesses)
        return MemeticSearch(population, space.scale)

    return make
