"""The paper's combination of genetic operators and particle swarm (paper, section IV.C).

Particles are sorted by fitness; the worse half is crossed and mutated; then all move as a swarm.
Settings the paper leaves open are those of Clerc and Kennedy (2002) for the swarm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.identify.estimator import half_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settings:
    """Population and operator settings, the same for every problem.

    ``inertia`` and ``pull`` are Clerc and Kennedy's constriction (0.7298, 1.4962); ``mutation`` is
    the chance that a gene mutates and ``spread`` its size as a share of the bounds.
    """

    population: int = 40
    inertia: float = 0.7298
    pull: float = 1.4962
    mutation: float = 0.15
    spread: float = 0.1
    tolerance: float = 1e-4
    patience: int = 15


class Combination:
    """Search within ``low`` and ``high``; ``seeds`` (rows of points) join the first generation."""

    def __init__(
        self,
        low: Array,
        high: Array,
        seed: int,
        seeds: Array | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.low, self.high = low, high
        self.settings = settings or Settings()
        self.rng = np.random.default_rng(seed)
        width = high - low
        count = self.settings.population
        self.position = low + width * self.rng.random((count, low.size))
        if seeds is not None and len(seeds):
            self.position[: len(seeds)] = np.clip(seeds[:count], low, high)
        self.velocity = 0.1 * width * self.rng.uniform(-1.0, 1.0, self.position.shape)
        self.best = self.position.copy()
        self.best_cost = np.full(count, np.inf)
        self.stopped = ""
        self._quiet = 0

    def ask(self) -> Array:
        """The swarm's positions."""
        return self.position

    def tell(self, points: Array, residuals: Array) -> None:
        """Keep each particle's best; cross and mutate the worse half; move all."""
        costs = half_squares(residuals)
        before = float(self.best_cost.min())
        better = costs < self.best_cost
        self.best[better] = points[better]
        self.best_cost[better] = costs[better]
        now = float(self.best_cost.min())
        self._quiet = 0 if now < before * (1.0 - self.settings.tolerance) else self._quiet + 1
        if self._quiet >= self.settings.patience:
            self.stopped = f"converged: no better point in {self._quiet} generations"
            return
        order = np.argsort(costs)
        half = len(order) // 2
        better_half, worse_half = order[:half], order[half:]
        children = mutated(
            crossed(self.position[better_half], len(worse_half), self.rng),
            self.low,
            self.high,
            self.settings,
            self.rng,
        )
        self.position[worse_half] = children
        self._move()

    def _move(self) -> None:
        leader = self.best[int(np.argmin(self.best_cost))]
        shape = self.position.shape
        own = self.settings.pull * self.rng.random(shape) * (self.best - self.position)
        social = self.settings.pull * self.rng.random(shape) * (leader - self.position)
        self.velocity = self.settings.inertia * self.velocity + own + social
        moved = self.position + self.velocity
        outside = (moved < self.low) | (moved > self.high)
        self.velocity[outside] *= -0.5
        self.position = np.clip(moved, self.low, self.high)


def crossed(parents: Array, count: int, rng: np.random.Generator) -> Array:
    """Children (count, genes) between two parents each: arithmetic crossover, a share a gene."""
    first = parents[rng.integers(len(parents), size=count)]
    second = parents[rng.integers(len(parents), size=count)]
    share = rng.random(first.shape)
    return np.asarray(share * first + (1.0 - share) * second)


def mutated(
    children: Array, low: Array, high: Array, settings: Settings, rng: np.random.Generator
) -> Array:
    """Gaussian mutation of single genes, kept within the bounds."""
    hit = rng.random(children.shape) < settings.mutation
    noise = rng.standard_normal(children.shape) * settings.spread * (high - low)
    return np.clip(np.where(hit, children + noise, children), low, high)
