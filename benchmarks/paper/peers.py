"""Other people's searches, run on the same trials and counted in the same way.

Each gets the same box, population and budget, and its own defaults for everything else. An
evaluation counts when it is asked for; a run ends with the first one below the goal.
"""

from __future__ import annotations

import contextlib
import logging
import warnings
from collections.abc import Callable, Mapping
from importlib.metadata import version

import numpy as np

from servosight.identify.search import half_squares
from servosight.models.core import Array

from .search_counts import POPULATION, Search
from .trials import SearchProblem


class BudgetSpent(Exception):
    """The goal was passed, or the budget is spent."""


class EvaluationCounter:
    """Costs of points as a peer asks for them."""

    def __init__(self, trial: SearchProblem, budget: int) -> None:
        self.trial, self.budget = trial, budget
        self.spent = 0
        self.converged = False

    def __call__(self, points: Array) -> Array:
        """Costs (batch,) of ``points`` (batch, coordinates)."""
        room = self.budget - self.spent
        if room <= 0:
            raise BudgetSpent
        costs = half_squares(self.trial.residuals(np.asarray(points, dtype=np.float64)[:room]))
        below = np.flatnonzero(costs < self.trial.goal)
        if below.size:
            self.spent += int(below[0]) + 1
            self.converged = True
            raise BudgetSpent
        self.spent += len(costs)
        if len(costs) < len(points):
            raise BudgetSpent
        return costs


def peer(run: Callable[[SearchProblem, int, EvaluationCounter], None]) -> Search:
    """A search that counts what ``run`` asks for."""

    def search(trial: SearchProblem, seed: int, budget: int) -> int | None:
        counter = EvaluationCounter(trial, budget)
        with contextlib.suppress(BudgetSpent):
            run(trial, seed, counter)
        return counter.spent if counter.converged else None

    return search


def differential_evolution(trial: SearchProblem, seed: int, cost: EvaluationCounter) -> None:
    """scipy's, best1bin, without its polish; its population is a whole multiple of the genes."""
    from scipy import optimize

    optimize.differential_evolution(
        lambda point: float(cost(point[None, :])[0]),
        list(zip(trial.low, trial.high, strict=True)),
        popsize=max(POPULATION // trial.low.size, 1),
        maxiter=10**6,
        tol=0.0,
        polish=False,
        rng=seed,
    )


def evolution_strategy(
    population: int | None,
) -> Callable[[SearchProblem, int, EvaluationCounter], None]:
    """Hansen's CMA-ES within bounds, restarted where it stops; None is its own population."""

    def run(trial: SearchProblem, seed: int, cost: EvaluationCounter) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import cma
        width = trial.high - trial.low
        rng = np.random.default_rng(seed)
        own = {} if population is None else {"popsize": population}
        for restart in range(1, 1000):
            options = {"bounds": [0, 1], "seed": 1000 * seed + restart, "verbose": -9, **own}
            strategy = cma.CMAEvolutionStrategy(rng.random(width.size), 0.3, options)
            while not strategy.stop():
                points = strategy.ask()
                strategy.tell(points, list(cost(trial.low + width * np.array(points))))

    return run


def pyswarms(trial: SearchProblem, seed: int, cost: EvaluationCounter) -> None:
    """Its global-best swarm with the constriction that our own has; it draws from numpy's
    global state, which is all that can be seeded."""
    logging.disable(logging.WARNING)
    import pyswarms.single

    np.random.seed(seed)  # noqa: NPY002
    swarm = pyswarms.single.GlobalBestPSO(
        n_particles=POPULATION,
        dimensions=trial.low.size,
        options={"w": 0.7298, "c1": 1.4962, "c2": 1.4962},
        bounds=(trial.low, trial.high),
    )
    swarm.optimize(cost, iters=10**6, verbose=False)


PEERS: Mapping[str, Search] = {
    f"scipy {version('scipy')} differential_evolution": peer(differential_evolution),
    f"cma {version('cma')}, population {POPULATION}": peer(evolution_strategy(POPULATION)),
    f"cma {version('cma')}, its own population": peer(evolution_strategy(None)),
    f"pyswarms {version('pyswarms')} GlobalBestPSO": peer(pyswarms),
}
"""By name and version."""
