"""Bounds of the static gain k that keep a model from following its recordings for other reasons."""

from __future__ import annotations

import numpy as np

from servosight.identify.fit import Solution
from servosight.identify.problem import Problem, linear_start
from servosight.models.core import CORE

LEAST_GAIN = 0.2
"""No model's k is less than this share of the gain that the recordings show."""


def linear_k_bounds(problem: Problem) -> tuple[float, float]:
    """For the linear model of ``problem``: the sign with which the angle follows the command.

    A long decay from a free initial state can follow a record that moves once better than any
    answer to the command, and leaves k of either sign.
    """
    _, most = CORE[0].search_bounds
    return (0.0, most) if linear_start(problem)[0] >= 0.0 else (-most, 0.0)


def loaded_k_bounds(linear: Solution) -> tuple[float, float]:
    """For models with effects, from the fit of the linear one.

    A weight that falls over, or detents as steep, can cancel the loop's stiffness: k and T then go
    towards zero together, the gain stays, and what is left bends as no servo does.
    """
    recordings = linear.problem.recordings
    low, most = linear.problem.bounds[0][0], CORE[0].search_bounds[1]
    k = abs(float(linear.outcome.point[0]))
    moved = np.sqrt(sum(np.var(recording.angle_deg) for recording in recordings))
    asked = np.sqrt(sum(np.var(recording.command_deg) for recording in recordings))
    least = LEAST_GAIN * min(k, float(moved / max(asked, 1e-12)))
    return (least, most) if low >= 0.0 else (-most, -least)
