"""Searches counted over many seeds: how many arrive, and after how many evaluations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from servosight.identify.search import (
    OPERATORS,
    LevenbergMarquardt,
    MemeticSearch,
    Population,
    PopulationOptions,
    drive,
)

from .trials import SearchProblem

POPULATION = 40
GENERATIONS = 100
"""Table I's limits: the paper gives none. Fixed before the first run, the same for all."""

Search = Callable[[SearchProblem, int, int], int | None]
"""Of a trial, a seed and a budget: evaluations until the goal was passed, None where it was not."""


@dataclass(frozen=True)
class Tally:
    """``evaluations`` of the runs that converged, of ``runs`` in all."""

    runs: int
    evaluations: tuple[int, ...]

    @property
    def converged(self) -> int:
        """How many runs converged."""
        return len(self.evaluations)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the chance to arrive."""
        return wilson(self.converged, self.runs)

    def generations(self, population: int = POPULATION) -> float:
        """Mean generation in which a run converged; NaN where none did."""
        needed = [math.ceil(count / population) for count in self.evaluations]
        return float(np.mean(needed)) if needed else math.nan

    @property
    def median(self) -> float:
        """Median evaluations of the runs that converged; NaN where none did."""
        return float(np.median(self.evaluations)) if self.evaluations else math.nan


def tally(search: Search, trial: SearchProblem, seeds: Iterable[int], budget: int) -> Tally:
    """Run ``search`` once for each seed."""
    found = [search(trial, seed, budget) for seed in seeds]
    return Tally(len(found), tuple(count for count in found if count is not None))


def wilson(successes: int, runs: int, z: float = 1.959964) -> tuple[float, float]:
    """95 % score interval of a probability (Wilson, J. American Statistical Assoc. 22, 1927)."""
    share = successes / runs
    middle = share + z**2 / (2 * runs)
    spread = z * math.sqrt(share * (1.0 - share) / runs + z**2 / (4 * runs**2))
    low, high = ((middle + sign * spread) / (1.0 + z**2 / runs) for sign in (-1.0, 1.0))
    return (low if successes else 0.0), (high if successes < runs else 1.0)


def population(name: str, options: PopulationOptions | None = None) -> Search:
    """One of the three algorithms, as long as the budget lasts: it does not stop by itself."""
    endless = options or PopulationOptions(population=POPULATION, patience=10**9)

    def search(trial: SearchProblem, seed: int, budget: int) -> int | None:
        estimator = Population(OPERATORS[name], trial.low, trial.high, seed, options=endless)
        outcome = drive(estimator, trial.residuals, budget, trial.goal)
        return outcome.evaluations if outcome.cost < trial.goal else None

    return search


def polished(name: str) -> Search:
    """One of the three with its descents, which stops by itself: before the goal is a failure."""

    def search(trial: SearchProblem, seed: int, budget: int) -> int | None:
        swarm = Population(OPERATORS[name], trial.low, trial.high, seed)
        outcome = drive(MemeticSearch(swarm, trial.scale), trial.residuals, budget, trial.goal)
        return outcome.evaluations if outcome.cost < trial.goal else None

    return search


def whole_polished(trial: SearchProblem, seed: int, budget: int) -> int | None:
    """The polished combination until it stops by itself, as `servosight identify` would see it."""
    swarm = Population(OPERATORS["combination"], trial.low, trial.high, seed)
    outcome = drive(MemeticSearch(swarm, trial.scale), trial.residuals, budget)
    return outcome.evaluations if outcome.cost < trial.goal else None


def descents(trial: SearchProblem, seed: int, budget: int) -> int | None:
    """Levenberg-Marquardt from one point in the box after another."""
    rng = np.random.default_rng(seed)
    spent = 0
    while spent < budget:
        start = rng.uniform(trial.low, trial.high)
        one = LevenbergMarquardt(start, trial.low, trial.high, trial.scale)
        outcome = drive(one, trial.residuals, budget - spent, trial.goal)
        spent += outcome.evaluations
        if outcome.cost < trial.goal:
            return spent if spent <= budget else None
    return None


ALGORITHMS: Mapping[str, Search] = {
    "genetic algorithm": population("ga"),
    "particle swarm": population("pso"),
    "combination": population("combination"),
}
"""The paper's three, in the order of its Table I."""

FINISHED: Mapping[str, Search] = {
    "combination, polished": polished("combination"),
    "the same, until it stops by itself": whole_polished,
    "particle swarm, polished": polished("pso"),
    "genetic algorithm, polished": polished("ga"),
    "Gauss-Newton from random points": descents,
}
"""With descents of Gauss-Newton; every simulation counts, those for its Jacobian included."""
