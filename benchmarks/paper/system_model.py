"""The paper's test system, eq. 3, identified by its three algorithms (figures 11 to 16)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.identify.search import OPERATORS, Population, PopulationOptions, drive
from servosight.models.core import Array

TRUE = np.array([1.0, -0.4, 1.5, 0.2])
"""Of y(k-1), y(k-2), u(k-1) and u(k-2)."""
NAMES = ("y(k-1)", "y(k-2)", "u(k-1)", "u(k-2)")
SAMPLES, NOISE = 500, 0.1
EDGE = 2.0
POPULATION, GENERATIONS = 40, 100


@dataclass(frozen=True)
class Record:
    """Regressors (samples, 4) and answers (samples,) of eq. 3: answers = regressors @ TRUE + v."""

    regressors: Array
    answers: Array

    @property
    def least_squares(self) -> Array:
        """What the best of all searches finds."""
        return np.asarray(np.linalg.lstsq(self.regressors, self.answers, rcond=None)[0])

    def residuals(self, points: Array) -> Array:
        """One-step prediction errors (batch, samples) of ``points`` (batch, 4)."""
        return self.answers - points @ self.regressors.T


def record(seed: int) -> Record:
    """Eq. 3 under random signs of size 1, v white with a standard deviation of 0.1."""
    rng = np.random.default_rng([seed, 3])
    u = rng.choice([-1.0, 1.0], SAMPLES + 2)
    v = rng.normal(0.0, NOISE, SAMPLES + 2)
    y = np.zeros(SAMPLES + 2)
    rows = np.zeros((SAMPLES + 2, 4))
    for k in range(2, SAMPLES + 2):
        rows[k] = y[k - 1], y[k - 2], u[k - 1], u[k - 2]
        y[k] = rows[k] @ TRUE + v[k]
    return Record(rows[2:], y[2:])


def paths(name: str, seed: int, noise: Record) -> Array:
    """Best point after each of the generations, (generations, 4), within +-2."""
    edge = np.full(4, EDGE)
    endless = PopulationOptions(population=POPULATION, patience=10**9)
    swarm = Population(OPERATORS[name], -edge, edge, seed, options=endless)
    return drive(swarm, noise.residuals, GENERATIONS * POPULATION).path


def errors(path: Array) -> Array:
    """Distance of each point of a path (generations, 4) from the truth, (generations,)."""
    return np.asarray(np.linalg.norm(path - TRUE, axis=1))
