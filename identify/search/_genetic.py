"""The genetic algorithm (paper, section IV.A), for genes that are real numbers.

Crossover and mutation are those of the breeder genetic algorithm: Muehlenbein and
Schlierkamp-Voosen, Predictive models for the breeder genetic algorithm, Evolutionary Computation
1(1), 1993, sections 3 and 4.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._population_state import Box, Flock, Settings
from servosight.models.core import Array


def breed(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """Tournaments of two choose parents; children cross and mutate; the elite survives."""
    count = len(flock.cost)
    rivals = rng.integers(count, size=(2, count))
    winners = np.where(flock.cost[rivals[0]] < flock.cost[rivals[1]], rivals[0], rivals[1])
    children = offspring(flock.position[winners], count, box, settings, rng)
    elite = np.argsort(flock.cost)[: settings.elite]
    children[: settings.elite] = flock.position[elite]
    return replace(flock, position=children)


def offspring(
    parents: Array, count: int, box: Box, settings: Settings, rng: np.random.Generator
) -> Array:
    """``count`` children of ``parents`` (members, genes), crossed and mutated, within the box."""
    children = crossed(parents, count, settings, rng)
    return box.reflected(mutated(children, box, settings, rng))


def crossed(parents: Array, count: int, settings: Settings, rng: np.random.Generator) -> Array:
    """Children (count, genes) on the line through two parents each.

    One share for all genes: on a line children follow a valley that is not along an axis.
    """
    first = parents[rng.integers(len(parents), size=count)]
    second = parents[rng.integers(len(parents), size=count)]
    share = rng.uniform(-settings.overreach, 1.0 + settings.overreach, (count, 1))
    return np.asarray(first + share * (second - first))


def mutated(children: Array, box: Box, settings: Settings, rng: np.random.Generator) -> Array:
    """Single genes moved by steps of all sizes, each octave as likely as the next.

    So neither a wide search nor a fine one needs its own scale.
    """
    hit = rng.random(children.shape) * box.low.size < settings.mutations
    size = settings.reach * 2.0 ** (-settings.octaves * rng.random(children.shape))
    sign = rng.choice([-1.0, 1.0], children.shape)
    return np.where(hit, children + sign * size * box.width, children)
