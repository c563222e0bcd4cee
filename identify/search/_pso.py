"""Particle swarm (paper, section IV.B): Kennedy and Eberhart, Proc. ICNN 1995, constricted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._population_state import Bounds, PopulationOptions, PopulationState


def pso_step(
    state: PopulationState, bounds: Bounds, options: PopulationOptions, rng: np.random.Generator
) -> PopulationState:
    """Each member accelerates towards its own best and the best of all; bounds reflect it."""
    shape = state.position.shape
    own = rng.random(shape) * (state.best - state.position)
    social = rng.random(shape) * (state.best_point - state.position)
    # c1 own + c2 social, in the order of operations whose rounding docs/paper.md was run with.
    acceleration = options.c1 * (own + options.c2 / options.c1 * social)
    velocity = options.inertia * state.velocity + acceleration
    fastest = options.highest_speed * bounds.width
    velocity = np.clip(velocity, -fastest, fastest)
    moved = state.position + velocity
    passed = (moved < bounds.low) | (moved > bounds.high)
    return replace(
        state, position=bounds.reflected(moved), velocity=np.where(passed, -velocity, velocity)
    )
