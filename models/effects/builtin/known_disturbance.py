"""A force or torque from outside that the recording holds beside command and angle."""

from __future__ import annotations

import numpy as np

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place
from servosight.models.effects._initial_guess import one


def term(disturbance: float, gain: float) -> float:
    """Torque in the direction of positive motion [deg]."""
    return gain * disturbance


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """The size that explains the residual best, read off the recorded disturbance."""
    largest = float(np.max(np.abs(features.curves.disturbance), initial=0.0))
    plain = features.residual_deg / (largest or 1.0)
    found = -one(features.curves, features.curves.disturbance) if largest else 0.0
    return ((found or plain,), (-plain,))


EFFECT = Effect(
    id="known_disturbance",
    place=Place.INPUT,
    parameters=(
        Parameter(
            "gain",
            "deg/unit",
            -1e4,
            1e4,
            0.0,
            "torque per unit of the recorded disturbance, in degrees of position error",
            TORQUE,
            free_unit=True,
        ),
    ),
    equation="T^2 dw/dt + 2 xi T w = ... + gain d(t), d the recorded disturbance",
    looks_like="the servo gives way whenever the disturbance acts, in its direction, and returns "
    "afterwards",
    cause="a force or torque from outside that was applied on purpose or measured: weights, a "
    "second drive, pulses, feed-forward torque",
    confirm="apply a known force at rest and read the angle: it moves by gain times the force",
    remedy="add the disturbance to the command (feed-forward), or stiffen the position loop",
    source="Janot, Gautier, Brunot, Data set and reference models of EMPS (2019)",
    starts=starts,
    term=term,
)
