"""What a population search works on: a generation of members within bounds, and their memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array


@dataclass(frozen=True)
class PopulationOptions:
    """Population and operators, the same for every problem and for all three algorithms.

    The paper gives none of these values. Each is what its source recommends, except where a reason
    is given; none was chosen on the seeds that docs/paper.md reports.

    ``inertia`` and the acceleration coefficients ``c1`` (own best) and ``c2`` (best of all):
    constriction, phi = 4.1 (Clerc and Kennedy, IEEE Trans. Evolutionary Computation 6(1), 2002).
    ``highest_speed``: a member moves by at most this share of the range in one generation (Eberhart
    and Shi, Proc. CEC 2000, limit a constricted swarm by its range).

    ``recombination_distance``: how far a child may lie outside its parents, as a share of their
    distance. At 0.37 recombination alone keeps a population's variance; a half (Eshelman and
    Schaffer, FOGA 2, 1993) compensates what selection removes. ``mutations``: mean number of
    mutated coordinates of a child. ``mutation_range``: the largest mutation as a share of the
    range; the smallest is 2^-``mutation_precision`` of it (both Muehlenbein and
    Schlierkamp-Voosen, Evolutionary Computation 1(1), 1993). ``elite``: parents that survive.

    A search stops where ``patience`` generations lower the best cost by less than ``tolerance``.
    """

    population: int = 40
    inertia: float = 0.7298
    c1: float = 1.4962
    c2: float = 1.4962
    highest_speed: float = 0.5
    recombination_distance: float = 0.5
    mutations: float = 1.0
    mutation_range: float = 0.1
    mutation_precision: float = 16.0
    elite: int = 2
    tolerance: float = 1e-4
    patience: int = 15


@dataclass(frozen=True)
class Bounds:
    """Bounds of the search, each (coordinates,)."""

    low: Array
    high: Array

    @property
    def width(self) -> Array:
        """Upper minus lower bound."""
        return self.high - self.low

    def reflected(self, points: Array) -> Array:
        """Points (members, coordinates), reflected where they exceed a bound.

        Clipping would collect them on the bound, where the minimum seldom is.
        """
        width = np.maximum(self.width, np.finfo(np.float64).tiny)
        along = np.mod(points - self.low, 2.0 * width)
        folded = self.low + np.minimum(along, 2.0 * width - along)
        return np.asarray(np.clip(folded, self.low, self.high))


@dataclass(frozen=True)
class PopulationState:
    """One generation: position, velocity and cost of each member, and the best it has found.

    ``position``, ``velocity`` and ``best`` (members, coordinates), ``cost`` and ``best_cost``
    (members,).
    """

    position: Array
    velocity: Array
    cost: Array
    best: Array
    best_cost: Array

    @property
    def best_point(self) -> Array:
        """The best point that any member has found, (coordinates,)."""
        return np.asarray(self.best[int(np.argmin(self.best_cost))])

    def with_cost(self, cost: Array) -> PopulationState:
        """The state with the ``cost`` (members,) of its positions, and each member's best."""
        better = cost < self.best_cost
        return replace(
            self,
            cost=cost,
            best=np.where(better[:, None], self.position, self.best),
            best_cost=np.where(better, cost, self.best_cost),
        )

    def with_best(self, point: Array, cost: float) -> PopulationState:
        """The state whose best member remembers a better ``point`` (coordinates,)."""
        first = np.arange(len(self.best_cost)) == int(np.argmin(self.best_cost))
        return replace(
            self,
            best=np.where(first[:, None], point, self.best),
            best_cost=np.where(first, cost, self.best_cost),
        )


Operator = Callable[
    [PopulationState, Bounds, PopulationOptions, np.random.Generator], PopulationState
]
"""From a generation whose costs are known to the next one."""


def initial_state(
    bounds: Bounds, count: int, rng: np.random.Generator, guesses: Array | None
) -> PopulationState:
    """A Latin hypercube at rest; ``guesses`` (points, coordinates) replace the first members.

    Each coordinate's range is covered evenly whatever the count (McKay, Beckman and Conover,
    Technometrics 21(2), 1979); a Sobol sequence does so for powers of two only.
    """
    shape = (count, bounds.low.size)
    strata = rng.permuted(np.tile(np.arange(count)[:, None], (1, bounds.low.size)), axis=0)
    position = bounds.low + bounds.width * (strata + rng.random(shape)) / count
    if guesses is not None and len(guesses):
        position[: len(guesses)] = np.clip(guesses[:count], bounds.low, bounds.high)
    position = np.clip(position, bounds.low, bounds.high)
    unknown = np.full(count, np.inf)
    return PopulationState(position, np.zeros(shape), unknown, position.copy(), unknown.copy())
