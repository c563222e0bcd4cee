"""Particle swarm (paper, section IV.B): Kennedy and Eberhart, Proc. ICNN 1995, constricted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.search._population_state import Box, Flock, Settings


def fly(flock: Flock, box: Box, settings: Settings, rng: np.random.Generator) -> Flock:
    """Each member is drawn to its own best and to the best of all; bounds reflect it."""
    shape = flock.position.shape
    own = rng.random(shape) * (flock.best - flock.position)
    social = rng.random(shape) * (flock.leader - flock.position)
    velocity = settings.inertia * flock.velocity + settings.pull * (own + social)
    velocity = np.clip(velocity, -settings.speed * box.width, settings.speed * box.width)
    moved = flock.position + velocity
    passed = (moved < box.low) | (moved > box.high)
    return replace(
        flock, position=box.reflected(moved), velocity=np.where(passed, -velocity, velocity)
    )
