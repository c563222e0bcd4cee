"""Terms of a law over angle and speed: what pushes the surface whatever the drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from servosight.diagnose.discrepancy.basis._term import (
    BasisMotion,
    BasisTerm,
    Extent,
    Point,
    alone,
    as_found,
    unread,
)
from servosight.models.core import TORQUE, Array, Parameter, Scaling
from servosight.models.effects import Effect, Place

_WORDS: dict[str, Any] = {
    "looks_like": "the torque shown in the report",
    "cause": "not known yet",
    "confirm": "not known yet",
    "remedy": "not known yet",
    "source": "found in a recording by servosight diagnose",
    "starts": unread,
}
"""The words of a term that nobody has named."""


def nameless(
    place: Place,
    name: str,
    equation: str,
    parameters: tuple[Parameter, ...],
    states: int = 0,
    **hooks: Any,
) -> Effect:
    """An effect without a name of its own."""
    return Effect(name, place, parameters, equation, states=states, **_WORDS, **hooks)


def load(
    name: str, equation: str, parameters: tuple[Parameter, ...], states: int = 0, **hooks: Any
) -> Effect:
    """The same as a LOAD."""
    return nameless(Place.LOAD, name, equation, parameters, states, **hooks)


def coefficient(
    name: str, unit: str, meaning: str, low: float, high: float, scaling: Scaling = TORQUE
) -> Parameter:
    """A parameter that vanishes at 0."""
    return Parameter(name, unit, low, high, 0.0, meaning, scaling)


# Powers of the angle


def square_term(theta: float, w: float, square: float) -> float:
    """Torque [deg], the same on both sides of the zero angle."""
    return square * theta * theta


def cube_term(theta: float, w: float, cube: float) -> float:
    """Torque [deg]: a spring that stiffens, or softens where negative."""
    return cube * theta * theta * theta


def cube_resolution(T: float, theta: float, cube: float) -> float:
    """Longest step [s] that follows the swing on the stiffer spring."""
    return max(0.4 * T / math.sqrt(1.0 + 3.0 * abs(cube) * theta * theta), 0.01 * T)


ANGLE_SQUARE = BasisTerm(
    load(
        "angle_square",
        "load = square theta^2",
        (coefficient("square", "deg/deg^2", "torque over the square of the angle", -1.0, 1.0),),
        term=square_term,
    ),
    "depends on the square of the angle",
    alone,
    lambda motion: motion.angle_deg[None, :] ** 2,
    as_found,
)
ANGLE_CUBE = BasisTerm(
    load(
        "angle_cube",
        "load = cube theta^3",
        (coefficient("cube", "deg/deg^3", "torque over the cube of the angle", -0.1, 1.0),),
        term=cube_term,
        resolution=cube_resolution,
    ),
    "depends on the cube of the angle",
    alone,
    lambda motion: motion.angle_deg[None, :] ** 3,
    as_found,
)


# One-sided springs


def upper_term(theta: float, w: float, stiffness: float, damping: float, angle: float) -> float:
    """Torque [deg] of a spring and a damper that are touched above ``angle`` [deg]."""
    if theta <= angle:
        return 0.0
    return max(stiffness * (theta - angle) + damping * w, 0.0)


def lower_term(theta: float, w: float, stiffness: float, damping: float, angle: float) -> float:
    """Torque [deg] of a spring and a damper that are touched below ``angle`` [deg]."""
    if theta >= angle:
        return 0.0
    return min(stiffness * (theta - angle) + damping * w, 0.0)


def upper_resolution(
    T: float,
    theta: float,
    w: float,
    acceleration: float,
    stiffness: float,
    damping: float,
    angle: float,
) -> float:
    """Longest step [s]: half the way to the spring, and what follows the swing against it."""
    swing = min(0.1 * T / math.sqrt(1.0 + stiffness), 0.1 * T * T / (damping + 1e-12))
    apart = 0.5 * max(angle - theta, 0.0)
    return max(swing, 0.005 * T, apart / (w + math.sqrt(acceleration * apart) + 1e-12))


def lower_resolution(
    T: float,
    theta: float,
    w: float,
    acceleration: float,
    stiffness: float,
    damping: float,
    angle: float,
) -> float:
    """Longest step [s]: half the way to the spring, and what follows the swing against it."""
    swing = min(0.1 * T / math.sqrt(1.0 + stiffness), 0.1 * T * T / (damping + 1e-12))
    apart = 0.5 * max(theta - angle, 0.0)
    return max(swing, 0.005 * T, apart / (w + math.sqrt(acceleration * apart) + 1e-12))


def _stop(name: str, side: str, term: Any, resolution: Any) -> Effect:
    return load(
        name,
        f"load = stiffness (theta - angle) + damping w {side} angle, never pulling; else 0",
        (
            coefficient(
                "stiffness", "deg/deg", "torque for each degree beyond the angle", 0.0, 300.0
            ),
            Parameter("damping", "deg/(deg/s)", 0.0, 1.0, 0.0, "torque over speed there", TORQUE),
            Parameter("angle", "deg", -720.0, 720.0, None, "angle of first contact"),
        ),
        term=term,
        resolution=resolution,
    )


def _stops(extent: Extent) -> Sequence[Point]:
    low, high = extent.angle_deg
    return [(float(angle),) for angle in low + (high - low) * np.linspace(0.03, 0.97, 32)]


def _touched(coefficients: Array, at: Point) -> Point | None:
    stiffness, damping = coefficients
    return (float(stiffness), max(float(damping), 0.0), *at) if stiffness > 0.0 else None


def _beyond(motion: BasisMotion, side: float, angle: float) -> Array:
    deep = motion.angle_deg - angle
    touching = side * deep > 0.0
    return np.array([deep * touching, motion.speed_deg_s * touching])


UPPER_STOP = BasisTerm(
    _stop("upper_stop", "above", upper_term, upper_resolution),
    "acts beyond an angle, on the positive side",
    _stops,
    lambda motion, angle: _beyond(motion, 1.0, angle),
    _touched,
)
LOWER_STOP = BasisTerm(
    _stop("lower_stop", "below", lower_term, lower_resolution),
    "acts beyond an angle, on the negative side",
    _stops,
    lambda motion, angle: _beyond(motion, -1.0, angle),
    _touched,
)


# Waves


def angle_wave_term(theta: float, w: float, sine: float, cosine: float, period: float) -> float:
    """Torque [deg] that repeats after ``period`` [deg]."""
    turn = 6.283185307179586 * theta / period
    return sine * math.sin(turn) + cosine * math.cos(turn)


def angle_wave_resolution(
    T: float, w: float, acceleration: float, sine: float, cosine: float, period: float
) -> float:
    """Longest step [s]: a tenth of a period's way, and of the swing in a detent."""
    way = 0.1 * period
    passage = 2.0 * way / (w + math.sqrt(w * w + 2.0 * acceleration * way) + 1e-12)
    detent = 6.283185307179586 * (abs(sine) + abs(cosine)) / period
    return max(min(passage, 0.4 * T / math.sqrt(1.0 + detent)), 0.01 * T)


def _periods(extent: Extent) -> Sequence[Point]:
    line = 0.25 / extent.range_deg
    return [(float(1.0 / f),) for f in np.arange(2.0 * line, 100.0 * 4.0 * line, line)]


def _angle_waves(motion: BasisMotion, period: float) -> Array:
    turn = 2.0 * np.pi * motion.angle_deg / period
    # Where a period passes within a few instants the loop averages it, and instants would alias.
    slow = np.abs(motion.speed_deg_s) * motion.interval_s < 0.25 * period
    return np.array([np.sin(turn) * slow, np.cos(turn) * slow])


ANGLE_WAVE = BasisTerm(
    load(
        "angle_wave",
        "load = sine sin(2 pi theta / period) + cosine cos(2 pi theta / period)",
        (
            coefficient("sine", "deg", "torque in phase with the zero angle", -90.0, 90.0),
            coefficient("cosine", "deg", "torque a quarter of a period off", -90.0, 90.0),
            Parameter("period", "deg", 0.1, 720.0, None, "angle after which it repeats"),
        ),
        term=angle_wave_term,
        resolution=angle_wave_resolution,
    ),
    "is periodic in the angle",
    _periods,
    _angle_waves,
    as_found,
)
# Speed


def speed_square_term(theta: float, w: float, square: float) -> float:
    """Torque [deg] with the square of the speed, to the same side in both directions."""
    return square * w * w


def angle_damping_term(theta: float, w: float, slope: float, square: float) -> float:
    """Torque [deg] of a damper that changes with the angle."""
    return (slope * theta + square * theta * theta) * w


SPEED_SQUARE = BasisTerm(
    load(
        "speed_square",
        "load = square w^2",
        (coefficient("square", "deg/(deg/s)^2", "torque over squared speed", -1e-2, 1e-2),),
        term=speed_square_term,
    ),
    "depends on the square of the speed and acts to one side in both directions",
    alone,
    lambda motion: motion.speed_deg_s[None, :] ** 2,
    as_found,
)
ANGLE_DAMPING = BasisTerm(
    load(
        "angle_damping",
        "load = (slope theta + square theta^2) w",
        (
            coefficient("slope", "s/deg", "damping over angle", -0.1, 0.1),
            coefficient("square", "s/deg^2", "damping over squared angle", -0.01, 0.01),
        ),
        term=angle_damping_term,
    ),
    "is proportional to the speed, with a factor that depends on the angle",
    alone,
    lambda motion: np.array([motion.angle_deg, motion.angle_deg**2]) * motion.speed_deg_s,
    as_found,
)

LOADS = (
    ANGLE_SQUARE,
    ANGLE_CUBE,
    UPPER_STOP,
    LOWER_STOP,
    ANGLE_WAVE,
    SPEED_SQUARE,
    ANGLE_DAMPING,
)
