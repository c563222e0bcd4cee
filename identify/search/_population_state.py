"""What a population search works on: a generation of members in a box, and their memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array


@dataclass(frozen=True)
class Settings:
    """Population and operators, the same for every problem and for all three algorithms.

    The paper gives none of them. Each is the value that its source recommends, except where the
    reason is given; none was chosen on the seeds that docs/paper.md reports.

    ``inertia`` and ``pull``: constriction, phi = 4.1 (Clerc and Kennedy, IEEE Trans. Evolutionary
    Computation 6(1), 2002). ``speed``: a member moves by at most this share of the box in one
    generation (Eberhart and Shi, Proc. CEC 2000, clamp a constricted swarm by its range).

    ``overreach``: how far a child may lie beyond its parents, in their distance. At 0.37 crossing
    alone keeps a population's variance; half (Eshelman and Schaffer, FOGA 2, 1993) makes up for
    what selection takes. ``mutations``: genes that mutate, on average, in a child. ``reach``: the
    longest mutation as a share of the box; the shortest is 2^-``octaves`` of it (both Muehlenbein
    and Schlierkamp-Voosen, Evolutionary Computation 1(1), 1993). ``elite``: parents that survive.

    A search stops where ``patience`` generations lower the best cost by less than ``tolerance``.
    """

    population: int = 40
    inertia: float = 0.7298
    pull: float = 1.4962
    speed: float = 0.5
    overreach: float = 0.5
    mutations: float = 1.0
    reach: float = 0.1
    octaves: float = 16.0
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

    def reflected(self, points: Array) -> Array:
        """Points (members, genes), folded back where they pass a bound.

        Clipping would gather them on the bound, which is seldom where the answer lies.
        """
        width = np.maximum(self.width, np.finfo(np.float64).tiny)
        along = np.mod(points - self.low, 2.0 * width)
        folded = self.low + np.minimum(along, 2.0 * width - along)
        return np.asarray(np.clip(folded, self.low, self.high))


@dataclass(frozen=True)
class Flock:
    """One generation: where each member is and moves, its cost, and the best it has seen."""

    position: Array
    velocity: Array
    cost: Array
    best: Array
    best_cost: Array

    @property
    def leader(self) -> Array:
        """The best point that any member has seen, (genes,)."""
        return np.asarray(self.best[int(np.argmin(self.best_cost))])

    def remembering(self, cost: Array) -> Flock:
        """The flock that has heard the ``cost`` (members,) of its positions."""
        better = cost < self.best_cost
        return replace(
            self,
            cost=cost,
            best=np.where(better[:, None], self.position, self.best),
            best_cost=np.where(better, cost, self.best_cost),
        )

    def led_by(self, point: Array, cost: float) -> Flock:
        """The flock whose leader remembers a better ``point`` (genes,) than it has seen."""
        first = np.arange(len(self.best_cost)) == int(np.argmin(self.best_cost))
        return replace(
            self,
            best=np.where(first[:, None], point, self.best),
            best_cost=np.where(first, cost, self.best_cost),
        )


Operator = Callable[[Flock, Box, Settings, np.random.Generator], Flock]
"""Takes a flock whose costs are known to the next generation."""


def first_flock(box: Box, count: int, rng: np.random.Generator, seeds: Array | None) -> Flock:
    """A Latin hypercube at rest; ``seeds`` (rows of points) take the first members' places.

    Each gene's range is covered evenly whatever the count (McKay, Beckman and Conover,
    Technometrics 21(2), 1979); a Sobol sequence does so for powers of two.
    """
    shape = (count, box.low.size)
    strata = rng.permuted(np.tile(np.arange(count)[:, None], (1, box.low.size)), axis=0)
    position = box.low + box.width * (strata + rng.random(shape)) / count
    if seeds is not None and len(seeds):
        position[: len(seeds)] = np.clip(seeds[:count], box.low, box.high)
    position = np.clip(position, box.low, box.high)
    unseen = np.full(count, np.inf)
    return Flock(position, np.zeros(shape), unseen, position.copy(), unseen.copy())
