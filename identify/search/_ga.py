"""The genetic algorithm (paper, section IV.A), for coordinates that are real numbers.

Recombination and mutation are those of the breeder genetic algorithm: Muehlenbein and
Schlierkamp-Voosen, Predictive models for the breeder genetic algorithm, Evolutionary Computation
1(1), 1993, sections 3 and 4.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._population_state import Bounds, PopulationOptions, PopulationState
from servosight.models.core import Array


def ga_step(
    state: PopulationState, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> PopulationState:
    """Tournaments of two select parents; children recombine and mutate; the elite survives."""
    count = len(state.cost)
    rivals = rng.integers(count, size=(2, count))
    winners = np.where(state.cost[rivals[0]] < state.cost[rivals[1]], rivals[0], rivals[1])
    children = offspring(state.position[winners], count, bounds, options, rng)
    elite = np.argsort(state.cost)[: options.elite]
    children[: options.elite] = state.position[elite]
    return replace(state, position=children)


def offspring(
    parents: Array, count: int, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> Array:
    """``count`` recombined and mutated children of ``parents`` (members, coordinates)."""
    children = recombined(parents, count, options, rng)
    return bounds.reflected(mutated(children, bounds, options, rng))


def recombined(
    parents: Array, count: int, options: PopulationOptions, rng: np.random.Generator
) -> Array:
    """Children (count, coordinates) on the line through two parents each.

    One share for all coordinates: on a line children follow a valley that is not along an axis.
    """
    first = parents[rng.integers(len(parents), size=count)]
    second = parents[rng.integers(len(parents), size=count)]
    beyond = options.recombination_distance
    share = rng.uniform(-beyond, 1.0 + beyond, (count, 1))
    return np.asarray(first + share * (second - first))


def mutated(
    children: Array, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> Array:
    """Single coordinates changed by steps whose size is uniform on a logarithmic scale.

    So a wide search and a fine one need no different scale.
    """
    hit = rng.random(children.shape) * bounds.low.size < options.mutations
    exponents = options.mutation_precision * rng.random(children.shape)
    size = options.mutation_range * 2.0 ** (-exponents)
    sign = rng.choice([-1.0, 1.0], children.shape)
    return np.where(hit, children + sign * size * bounds.width, children)
