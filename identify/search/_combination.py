"""The paper's combination (section IV.C) of genetic algorithm and particle swarm.

"Calculate and sort the fitness of each particle, then divide the particles into two parts
according to the optimal degree of fitness. The worst half should cross and mutation and then search
the optimal values in the way of particle swarm optimization with the better half."
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._genetic import offspring
from servosight.identify.search._population_state import Box, Flock, Settings
from servosight.identify.search._swarm import fly


def combine(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """The worse half is renewed by crossing and mutation, then all move as a swarm."""
    return fly(renew_worse_half(flock, box, settings, rng), box, settings, rng)


def renew_worse_half(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """Children of the better half take the places of the worse, at rest.

    They keep their places' memories of a best point, and no velocity: it belonged to where the
    member was. With it Rosenbrock takes twice the generations.
    """
    order = np.argsort(flock.cost)
    better, worse = np.split(order, [len(order) // 2])
    position, velocity = flock.position.copy(), flock.velocity.copy()
    position[worse] = offspring(flock.position[better], len(worse), box, settings, rng)
    velocity[worse] = 0.0
    return replace(flock, position=position, velocity=velocity)
