"""The paper's combination (section IV.C) of genetic algorithm and particle swarm.

"Calculate and sort the fitness of each particle, then divide the particles into two parts
according to the optimal degree of fitness. The worst half should cross and mutation and then search
the optimal values in the way of particle swarm optimization with the better half."
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._ga import offspring
from servosight.identify.search._population_state import Bounds, PopulationOptions, PopulationState
from servosight.identify.search._pso import pso_step


def hybrid_step(
    state: PopulationState, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> PopulationState:
    """The worse half is replaced by recombination and mutation, then all move as a swarm."""
    return pso_step(replace_worse_half(state, bounds, options, rng), bounds, options, rng)


def replace_worse_half(
    state: PopulationState, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> PopulationState:
    """Children of the better half replace the worse half, at rest.

    They keep the best points of the members that they replace, and no velocity: it belonged to the
    old position. With it Rosenbrock takes twice the generations.
    """
    order = np.argsort(state.cost)
    better, worse = np.split(order, [len(order) // 2])
    position, velocity = state.position.copy(), state.velocity.copy()
    position[worse] = offspring(state.position[better], len(worse), bounds, options, rng)
    velocity[worse] = 0.0
    return replace(state, position=position, velocity=velocity)
