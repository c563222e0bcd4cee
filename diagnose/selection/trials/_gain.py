"""The static gain k: held, or bounded so that no model follows its recordings for other reasons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.identify.problem import Problem, linear_start
from servosight.models.core import CORE, Recording, read_by_servo

LEAST_GAIN = 0.2
"""No model's k is less than this share of the gain that the recordings show."""
SENSOR_RANGES = {"T": (2e-3, 0.3), "bias": (-5.0, 5.0)}
"""Bounds of T [s] and bias [deg] where each angle is the reading of the servo's own sensor.

Command and reading share their zero, but for the dead band and the rounding of the firmware and
what a worn gear gives way; and no servo's T is longer than 0.3 s. One slow run with a weight on the
arm determines none of weight, bias and T: its best fits had biases of 700 deg and T of 2 s, and
their friction was that of no servo.
"""


def gain_of_sensor(recordings: Sequence[Recording]) -> dict[str, float]:
    """k = 1 where each angle is the reading of the sensor on which the servo's loop is closed.

    The loop compares the command with that very number, so they differ by load and friction alone.
    A weight on the arm and a k can stand in for one another, and so one run with k fitted names the
    weight and the next does not.

    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> gain_of_sensor([Recording("run", t, t, t, t, side="sensor")])
    {'k': 1.0}
    """
    return {"k": 1.0} if read_by_servo(recordings) else {}


def at_one_gain(recordings: Sequence[Recording]) -> bool:
    """True where all were made with the same gain of the position loop.

    Load and friction in degrees fall with the gain, and k does not: only recordings at several
    gains tell them apart.
    """
    return len({one.relative_gain for one in recordings}) == 1


def ranges(problem: Problem) -> dict[str, tuple[float, float]]:
    """Bounds of k for all models of the recordings, and for logs of a servo's sensor of more."""
    of_servo = SENSOR_RANGES if read_by_servo(problem.recordings) else {}
    return {"k": k_bounds(problem), **of_servo}


def k_bounds(problem: Problem) -> tuple[float, float]:
    """For all models of the recordings of ``problem``, a linear one: the sign and least size of k.

    A long decay from a free initial state can follow a record that moves once better than any
    answer to the command, and leaves a k of either sign or of zero. A weight that falls over, or
    detents as steep, can cancel the loop's stiffness: k and T then go towards zero together, the
    gain stays, and what is left bends as no servo does. The gain that is shown is the regression of
    the angle on the command through the best of some answers, or the ratio of their motions where
    that is less: at a resonance it is more.
    """
    shown = float(linear_start(problem)[0])
    moved = np.sqrt(sum(np.var(recording.angle_deg) for recording in problem.recordings))
    asked = np.sqrt(sum(np.var(recording.command_deg) for recording in problem.recordings))
    least = LEAST_GAIN * min(abs(shown), float(moved / max(asked, 1e-12)))
    _, most = CORE[0].search_bounds
    return (least, most) if shown >= 0.0 else (-most, -least)
