"""Terms of a law that oppose the motion and make it stick."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from servosight.diagnose.discrepancy.basis._load import coefficient, nameless
from servosight.diagnose.discrepancy.basis._term import (
    BasisMotion,
    BasisTerm,
    Extent,
    Point,
    alone,
    as_found,
    if_positive,
)
from servosight.models.core import FIXED, TORQUE, Array, Parameter
from servosight.models.effects import Effect, Place


def _friction(name: str, equation: str, parameters: tuple[Parameter, ...], **hooks: Any) -> Effect:
    return nameless(Place.FRICTION, name, equation, parameters, 0, **hooks)


# Over speed and drive


def level_term(rate: float, drive: float, load: float, level: float) -> float:
    """Size of the friction [deg]."""
    return level


def rest_term(rate: float, drive: float, load: float, excess: float, speed: float) -> float:
    """Size of a friction [deg] that is gone beyond ``speed`` [deg/s]."""
    share = rate / speed
    return excess * math.exp(-share * share)


def rest_resolution(T: float, w: float, acceleration: float, excess: float, speed: float) -> float:
    """Longest step [s] where friction falls with speed."""
    if w > 3.0 * speed:
        return math.inf
    growth = 0.15 * T * T * speed / (excess + 1e-12)
    return max(min(growth, 0.2 * speed / (acceleration + 1e-12)), 0.01 * T)


def drag_term(rate: float, drive: float, load: float, square: float) -> float:
    """Size of a drag [deg] at a speed [deg/s]."""
    return square * rate * rate


def drag_resolution(T: float, w: float, acceleration: float, square: float) -> float:
    """Longest step [s]: a quarter of the time in which drag brakes the speed at the step's end."""
    reach = T * T / (square + 1e-300)
    return max(0.25 * reach / (w + math.sqrt(w * w + acceleration * reach) + 1e-12), 0.01 * T)


def pressed_term(rate: float, drive: float, load: float, ratio: float) -> float:
    """Size of a friction [deg] in proportion to the drive."""
    return ratio * abs(drive)


LEVEL = BasisTerm(
    _friction(
        "dry_friction",
        "friction = level sign(w)",
        (coefficient("level", "deg", "friction", 0.0, 90.0),),
        term=level_term,
    ),
    "depends on the direction of motion",
    alone,
    lambda motion: motion.sign[None, :],
    if_positive,
)
REST = BasisTerm(
    _friction(
        "rest_friction",
        "friction = excess exp(-(w / speed)^2) sign(w)",
        (
            coefficient("excess", "deg", "friction near rest", 0.0, 90.0),
            Parameter("speed", "deg/s", 0.1, 1000.0, None, "speed at which it has vanished"),
        ),
        term=rest_term,
        resolution=rest_resolution,
    ),
    "depends on the direction of motion, only near rest",
    lambda extent: [(float(s * extent.speed_deg_s),) for s in (0.01, 0.03, 0.1, 0.3)],
    lambda motion, speed: (motion.sign * np.exp(-((motion.speed_deg_s / speed) ** 2)))[None, :],
    if_positive,
)
DRAG = BasisTerm(
    _friction(
        "speed_drag",
        "friction = square w^2 sign(w)",
        (coefficient("square", "deg/(deg/s)^2", "drag over the square of speed", 0.0, 1.0),),
        term=drag_term,
        resolution=drag_resolution,
    ),
    "depends on the square of the speed and acts against the motion",
    alone,
    lambda motion: (motion.speed_deg_s * np.abs(motion.speed_deg_s))[None, :],
    if_positive,
)
PRESSED = BasisTerm(
    _friction(
        "drive_friction",
        "friction = ratio |drive| sign(w)",
        (coefficient("ratio", "-", "friction for each unit of drive", 0.0, 0.95, FIXED),),
        term=pressed_term,
    ),
    "depends on the size of the drive and acts against the motion",
    alone,
    lambda motion: (np.abs(motion.drive_deg) * motion.sign)[None, :],
    if_positive,
)


# Over the angle: bristles too short to be seen (a Dahl model of 0.02 deg) hold what is at rest


def turn_term(
    theta: float, start: float, last: float, level: float, sine: float, cosine: float, period: float
) -> float:
    """Friction [deg] at an angle that is reached from ``start``, where it was ``last``.

    Its level is ``level`` + ``sine`` sin + ``cosine`` cos of the angle over ``period``.
    """
    here = 6.283185307179586 * theta / period
    there = 6.283185307179586 * start / period
    level_here = max(level + sine * math.sin(here) + cosine * math.cos(here), 1e-9)
    level_there = max(level + sine * math.sin(there) + cosine * math.cos(there), 1e-9)
    bound = 1.0 if theta > start else -1.0
    bent = min(max(last / level_there, -1.0), 1.0)
    return level_here * (bound - (bound - bent) * math.exp(-abs(theta - start) / 0.02))


def turn_resolution(
    T: float,
    w: float,
    acceleration: float,
    last: float,
    level: float,
    sine: float,
    cosine: float,
    period: float,
) -> float:
    """Longest step [s] that follows the bristles bending near rest, and the angle beyond."""
    way = 0.05 * period
    passage = 2.0 * way / (w + math.sqrt(w * w + 2.0 * acceleration * way) + 1e-12)
    if T * w > 0.1:
        return max(passage, 0.01 * T)
    size = level + abs(sine) + abs(cosine)
    swing = 0.4 * T / math.sqrt(1.0 + size / 0.02)
    bend = 0.02 / (w + math.sqrt(w * w + 0.02 * acceleration) + 1e-12)
    return max(min(swing, 0.5 * bend, passage), 0.01 * T)


def slope_term(
    theta: float, start: float, last: float, level: float, slope: float, square: float
) -> float:
    """Friction [deg] at an angle that is reached from ``start``, where it was ``last``.

    Its level is ``level`` + ``slope`` theta + ``square`` theta^2.
    """
    level_here = max(level + (slope + square * theta) * theta, 1e-9)
    level_there = max(level + (slope + square * start) * start, 1e-9)
    bound = 1.0 if theta > start else -1.0
    bent = min(max(last / level_there, -1.0), 1.0)
    return level_here * (bound - (bound - bent) * math.exp(-abs(theta - start) / 0.02))


def slope_resolution(
    T: float,
    theta: float,
    w: float,
    acceleration: float,
    last: float,
    level: float,
    slope: float,
    square: float,
) -> float:
    """Longest step [s] that follows the bristles bending near rest."""
    if T * w > 0.1:
        return math.inf
    size = abs(level) + (abs(slope) + abs(square * theta)) * abs(theta)
    swing = 0.4 * T / math.sqrt(1.0 + size / 0.02)
    bend = 0.02 / (w + math.sqrt(w * w + 0.02 * acceleration) + 1e-12)
    return max(min(swing, 0.5 * bend), 0.01 * T)


def _periods(extent: Extent) -> Sequence[Point]:
    line = 0.25 / extent.range_deg
    return [(float(1.0 / f),) for f in np.arange(2.0 * line, 80.0 * line, line)]


def _rubbing(motion: BasisMotion, period: float) -> Array:
    turn = 2.0 * np.pi * motion.angle_deg / period
    return np.array([np.ones_like(turn), np.sin(turn), np.cos(turn)]) * motion.sign


def _angle_shapes(motion: BasisMotion) -> Array:
    angle = motion.angle_deg
    return np.array([np.ones_like(angle), angle, angle**2]) * motion.sign


TURN = BasisTerm(
    nameless(
        Place.BRISTLE,
        "wavy_friction",
        "friction = (level + sine sin(2 pi theta / period) + cosine cos(...)) sign(w)",
        (
            coefficient("level", "deg", "mean friction", 0.0, 90.0),
            Parameter("sine", "deg", -90.0, 90.0, 0.0, "its change with the angle", TORQUE),
            Parameter(
                "cosine", "deg", -90.0, 90.0, 0.0, "its part a quarter of a period later", TORQUE
            ),
            Parameter("period", "deg", 0.5, 720.0, None, "angle after which it repeats"),
        ),
        0,
        term=turn_term,
        resolution=turn_resolution,
    ),
    "depends on the direction of motion, with a size that is periodic in the angle",
    _periods,
    _rubbing,
    if_positive,
)
SLOPE = BasisTerm(
    nameless(
        Place.BRISTLE,
        "angle_friction",
        "friction = (level + slope theta + square theta^2) sign(w), never below 0",
        (
            Parameter("level", "deg", -90.0, 90.0, 0.0, "friction at the zero angle", TORQUE),
            Parameter("slope", "deg/deg", -10.0, 10.0, 0.0, "its change with the angle", TORQUE),
            Parameter("square", "deg/deg^2", -1.0, 1.0, 0.0, "and with its square", TORQUE),
        ),
        0,
        term=slope_term,
        resolution=slope_resolution,
    ),
    "depends on the direction of motion, with a size that depends on the angle",
    alone,
    _angle_shapes,
    as_found,
)

FRICTIONS = (LEVEL, REST, DRAG, PRESSED, TURN, SLOPE)
