"""Forms that a missing torque may have: an effect without a name, and what it looks like.

The ladder chooses among effects that have a physical name. A law is built from plainer terms:
powers of the angle and the speed, one-sided springs, waves over angle and time, drift, memory of
the command or of the error. Each is an effect like any other, so that a law is confirmed by
simulation and can be written to a file; its torque along a known motion is what it is found by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.models.effects import Effect, GuessFeatures

Point = tuple[float, ...]


@dataclass(frozen=True)
class BasisMotion:
    """How one recording moved, on an even grid of time, (instants,) each.

    ``time_s`` counts from the first instant; ``force_deg`` is k times the command plus bias,
    ``drive_deg`` that minus the angle, ``sign`` the direction of motion, 0 near rest.
    """

    interval_s: float
    time_s: Array
    angle_deg: Array
    speed_deg_s: Array
    force_deg: Array
    sign: Array

    @property
    def drive_deg(self) -> Array:
        """Position error [deg]."""
        return self.force_deg - self.angle_deg


@dataclass(frozen=True)
class Extent:
    """What all motions together span: least and largest angle, speed, time, and the servo's T."""

    angle_deg: tuple[float, float]
    speed_deg_s: float
    duration_s: float
    T_s: float
    interval_s: float

    @classmethod
    def of(cls, motions: Sequence[BasisMotion], T_s: float) -> Extent:
        """The extent of some motions."""
        angles = np.concatenate([motion.angle_deg for motion in motions])
        return cls(
            (float(angles.min()), float(angles.max())),
            max(float(np.abs(motion.speed_deg_s).max()) for motion in motions),
            max(float(motion.time_s[-1]) for motion in motions),
            T_s,
            min(motion.interval_s for motion in motions),
        )

    @property
    def range_deg(self) -> float:
        """Largest minus smallest angle."""
        return self.angle_deg[1] - self.angle_deg[0]


@dataclass(frozen=True)
class BasisTerm:
    """A term of a law.

    ``shapes(motion, *at)`` are the torques [deg], (coefficients, instants), that oppose positive
    motion for coefficients of 1, at a point of ``grid``, which covers what does not enter linearly.
    ``start(coefficients, at)`` are the effect's parameters, or None where they make no sense.
    ``words`` name the torque in a sentence.
    """

    effect: Effect
    words: str
    grid: Callable[[Extent], Sequence[Point]]
    shapes: Callable[..., Array]
    start: Callable[[Array, Point], Point | None]


def alone(extent: Extent) -> Sequence[Point]:
    """The grid of a term that is linear in all its parameters."""
    return ((),)


def as_found(coefficients: Array, at: Point) -> Point:
    """Parameters are the coefficients, then the point of the grid."""
    return (*(float(c) for c in coefficients), *at)


def if_positive(coefficients: Array, at: Point) -> Point | None:
    """The same where the first coefficient is above 0."""
    return as_found(coefficients, at) if coefficients[0] > 0.0 else None


def times(low: float, high: float, count: int = 10) -> list[Point]:
    """Points at times from ``low`` to ``high`` [s], evenly in their logarithm."""
    return [(float(t),) for t in np.geomspace(low, high, count)]


def unread(features: GuessFeatures) -> tuple[Point, ...]:
    """A term has no guesses of its own: it starts where its coefficients were found."""
    return ()
