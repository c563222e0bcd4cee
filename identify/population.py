"""Population searches as compositions of operators: genetic, swarm, and the paper's combination.

A generation is a :class:`Flock`; an operator takes a flock to the next. The genetic algorithm
breeds (paper, section IV.A), the particle swarm flies (IV.B), and the combination renews the worse
half by breeding and then flies with all (IV.C). Settings that the paper leaves open are those of
Clerc and Kennedy (IEEE Trans. Evolutionary Computation 6(1), 2002) for the swarm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from servosight.identify.estimator import half_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settings:
    """Population and operators, the same for every problem.

    ``inertia`` and ``pull`` are Clerc and Kennedy's constriction; ``mutation`` is the chance that a
    gene mutates and ``spread`` its size as a share of the bounds; ``elite`` parents survive.
    """

    population: int = 40
    inertia: float = 0.7298
    pull: float = 1.4962
    mutation: float = 0.15
    spread: float = 0.1
    elite: int = 2
    tolerance: float = 1e-4
    patience: int = 15


@dataclass(frozen=True)
class Box:
    """Bounds of the search, each (genes,)."""

    low: Array
    high: Array

    @property
    def width(self) -> Array:
        """Upper minus lower bound."""
        return self.high - self.low


@dataclass(frozen=True)
class Flock:
    """One generation: where each member is and moves, its cost, and the best it has seen."""

    position: Array
    velocity: Array
    cost: Array
    best: Array
    best_cost: Array


Operator = Callable[[Flock, Box, Settings, np.random.Generator], Flock]


class Population:
    """An estimator that applies ``operators`` in turn after each generation.

    ``seeds`` (rows of points) join the first generation.
    """

    def __init__(
        self,
        operators: tuple[Operator, ...],
        low: Array,
        high: Array,
        seed: int,
        seeds: Array | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.operators = operators
        self.box = Box(low, high)
        self.settings = settings or Settings()
        self.rng = np.random.default_rng(seed)
        self.stopped = ""
        self._quiet = 0
        self.flock = _first(self.box, self.settings, self.rng, seeds)

    def ask(self) -> Array:
        """The members' positions."""
        return self.flock.position

    def tell(self, points: Array, residuals: Array) -> None:
        """Remember the best, stop where nothing improves, else make the next generation."""
        before = float(self.flock.best_cost.min())
        flock = _remember(self.flock, half_squares(residuals))
        improved = float(flock.best_cost.min()) < before * (1.0 - self.settings.tolerance)
        self._quiet = 0 if improved else self._quiet + 1
        if self._quiet >= self.settings.patience:
            self.stopped = f"converged: no better point in {self._quiet} generations"
        else:
            for operator in self.operators:
                flock = operator(flock, self.box, self.settings, self.rng)
        self.flock = flock


def breed(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """Tournaments of two choose parents; children cross and mutate; the elite survives."""
    count = len(flock.cost)
    rivals = rng.integers(count, size=(2, count))
    winners = np.where(flock.cost[rivals[0]] < flock.cost[rivals[1]], rivals[0], rivals[1])
    children = mutated(crossed(flock.position[winners], count, rng), box, settings, rng)
    elite = np.argsort(flock.cost)[: settings.elite]
    children[: settings.elite] = flock.position[elite]
    return replace(flock, position=children)


def renew_worse_half(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """The worse half is crossed, with parents of the better half, and mutated."""
    order = np.argsort(flock.cost)
    half = len(order) // 2
    children = crossed(flock.position[order[:half]], len(order) - half, rng)
    position = flock.position.copy()
    position[order[half:]] = mutated(children, box, settings, rng)
    return replace(flock, position=position)


def fly(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """Each member is drawn to its own best and to the best of all; bounds reflect."""
    leader = flock.best[int(np.argmin(flock.best_cost))]
    shape = flock.position.shape
    own = settings.pull * rng.random(shape) * (flock.best - flock.position)
    social = settings.pull * rng.random(shape) * (leader - flock.position)
    velocity = settings.inertia * flock.velocity + own + social
    moved = flock.position + velocity
    velocity[(moved < box.low) | (moved > box.high)] *= -0.5
    return replace(flock, position=np.clip(moved, box.low, box.high), velocity=velocity)


def crossed(parents: Array, count: int, rng: np.random.Generator) -> Array:
    """Children (count, genes) between two parents each: arithmetic crossover, a share a gene."""
    first = parents[rng.integers(len(parents), size=count)]
    second = parents[rng.integers(len(parents), size=count)]
    share = rng.random(first.shape)
    return np.asarray(share * first + (1.0 - share) * second)


def mutated(children: Array, box: Box, settings: Settings, rng: np.random.Generator) -> Array:
    """Gaussian mutation of single genes, kept within the bounds."""
    hit = rng.random(children.shape) < settings.mutation
    noise = rng.standard_normal(children.shape) * settings.spread * box.width
    return np.clip(np.where(hit, children + noise, children), box.low, box.high)


def _first(box: Box, settings: Settings, rng: np.random.Generator, seeds: Array | None) -> Flock:
    count = settings.population
    position = box.low + box.width * rng.random((count, box.low.size))
    if seeds is not None and len(seeds):
        position[: len(seeds)] = np.clip(seeds[:count], box.low, box.high)
    velocity = 0.1 * box.width * rng.uniform(-1.0, 1.0, position.shape)
    unseen = np.full(count, np.inf)
    return Flock(position, velocity, unseen, position.copy(), unseen.copy())


def _remember(flock: Flock, cost: Array) -> Flock:
    better = cost < flock.best_cost
    return replace(
        flock,
        cost=cost,
        best=np.where(better[:, None], flock.position, flock.best),
        best_cost=np.where(better, cost, flock.best_cost),
    )


OPERATORS: Mapping[str, tuple[Operator, ...]] = {
    "combination": (renew_worse_half, fly),
    "ga": (breed,),
    "pso": (fly,),
}
"""The population searches by name."""
