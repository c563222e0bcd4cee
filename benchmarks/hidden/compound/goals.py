"""What the servo of a compound trial is commanded: instants and goals of one recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from servosight.models import excitation as shapes
from servosight.models.core import Array

from .draw import FAMILIES, CompoundSetup, between
from .servo import ENCODER_DEG

Shape = Callable[[Array, float, float, np.random.Generator], Array]


def command(
    setup: CompoundSetup, run: str, part: str, gain: float, duration_s: float
) -> tuple[Array, Array]:
    """Poll instants [s] and goals [deg, whole encoder steps] of one recording.

    ``part`` is "gentle", "fast" or "mixed"; a run is a name, and another run another motion.
    """
    rng = setup.rng(run, part, gain, "command")
    period = 1.0 / setup.bus.rate_hz
    jitter = setup.rng(run, part, gain, "poll").exponential(
        setup.bus.poll_jitter_s, int(duration_s / period) + 1
    )
    time_s = np.cumsum(period + jitter)
    time_s = time_s[time_s < duration_s]
    size, fast = setup.amplitude_deg, between(rng, FAMILIES[setup.family].fast_hz)
    if part == "gentle":
        goal = _swaying(time_s, 0.7 * size, 0.15 * fast, rng)
    elif part == "fast":
        goal = _joined(time_s, [_steps, _sweep, _swaying], size, fast, rng)
    else:
        goal = _joined(time_s, [_swaying, _steps, _slow], size, 0.6 * fast, rng)
    rest = np.clip((time_s - 0.2) / 0.05, 0.0, 1.0)
    return time_s, ENCODER_DEG * np.round(rest * goal / ENCODER_DEG)


def _joined(
    time_s: Array, kinds: Sequence[Shape], size: float, fast_hz: float, rng: np.random.Generator
) -> Array:
    goal = np.zeros_like(time_s)
    edges = np.linspace(0.0, time_s[-1] + 1e-9, len(kinds) + 1)
    for place, start, end in zip(rng.permutation(len(kinds)), edges[:-1], edges[1:], strict=True):
        inside = (time_s >= start) & (time_s < end)
        goal[inside] = kinds[place](time_s[inside] - start, size, fast_hz, rng)
    return goal


def _swaying(time_s: Array, size: float, fast_hz: float, rng: np.random.Generator) -> Array:
    """Two sines, one modulated, as bam's ``sin_sin``."""
    a, b = float(rng.uniform(0.5, 0.8)), float(rng.uniform(2.5, 4.5))
    turn = 2.0 * np.pi * fast_hz * time_s
    return np.asarray(size * (a * np.sin(0.5 * turn) + (1.0 - a) * np.sin(0.4 * b * turn)))


def _steps(time_s: Array, size: float, fast_hz: float, rng: np.random.Generator) -> Array:
    return shapes.steps(time_s, size, 0.5 / fast_hz, int(rng.integers(2**31)))


def _sweep(time_s: Array, size: float, fast_hz: float, rng: np.random.Generator) -> Array:
    return shapes.chirp(time_s, 0.5 * size, 0.3, 2.0 * fast_hz)


def _slow(time_s: Array, size: float, fast_hz: float, rng: np.random.Generator) -> Array:
    return shapes.triangle(time_s, 0.6 * size, 0.3 * fast_hz)
