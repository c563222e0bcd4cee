"""Drag of a surface in a fluid, and windage."""

from __future__ import annotations

import math

import numpy as np

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import one


def term(speed: float, drive: float, load: float, coefficient: float) -> float:
    """Size of the friction torque [deg] at ``speed`` [deg/s]."""
    return coefficient * speed * speed


def resolution(T: float, w: float, acceleration: float, coefficient: float) -> float:
    """Longest step [s]: a quarter of the time in which drag brakes the speed at the step's end."""
    reach = T * T / (coefficient + 1e-300)
    return max(0.25 * reach / (w + math.sqrt(w * w + acceleration * reach) + 1e-12), 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """As the residual says, and torques of a half and twice the largest error at full speed."""
    size = features.drive_deg / features.speed_deg_s**2
    read = one(features.curves, features.curves.speed_deg_s * np.abs(features.curves.speed_deg_s))
    return ((max(read, 0.05 * size),), (0.5 * size,), (2.0 * size,))


EFFECT = Effect(
    id="quadratic_drag",
    place=Place.FRICTION,
    parameters=(
        Parameter(
            "coefficient",
            "deg/(deg/s)^2",
            0.0,
            1.0,
            0.0,
            "drag torque over the square of the speed",
            TORQUE,
        ),
    ),
    equation="friction = coefficient w^2 sign(w)",
    looks_like="fast motion is slower than the linear model, slow motion is right, and nothing "
    "sticks; twice the speed takes four times the torque",
    cause="surface in air or water, a fan's windage",
    confirm="take the surface off, or step in still air and in the stream: the difference grows "
    "with the square of the speed",
    remedy="a smaller surface, or feedforward of the drag",
    source="Hoerner, Fluid-Dynamic Drag (1965), chapter 1",
    starts=starts,
    term=term,
    resolution=resolution,
)
