"""The static gain k: bounded so that no model follows its recordings for other reasons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.identify.problem import Problem, linear_start, ranges_of_sensor
from servosight.models.core import CORE, Recording

LEAST_GAIN = 0.2
"""No model's k is less than this share of the gain that the recordings show."""


def at_one_gain(recordings: Sequence[Recording]) -> bool:
    """True where all were made with the same gain of the position loop.

    Load and friction in degrees fall with the gain, and k does not: only recordings at several
    gains tell them apart.
    """
    return len({one.relative_gain for one in recordings}) == 1


def ranges(problem: Problem) -> dict[str, tuple[float, float]]:
    """Bounds of k for all models of the recordings, and for logs of a servo's sensor of more."""
    return {"k": k_bounds(problem), **ranges_of_sensor(problem.recordings)}


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
