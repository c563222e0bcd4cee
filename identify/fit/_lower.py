"""Lower minima than the one in which a single search ends: friction, play and limits make many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.fit._horizon import over_horizons
from servosight.identify.fit._solution import Solution, polish
from servosight.identify.fit._together import fit_together
from servosight.identify.problem import linear_start

FAR, SEVERAL = 2.0, 2
"""Models of two effects or more are fitted at once where a search ends above twice the error that
would be enough."""


def fit_lower(solution: Solution, enough_deg: float) -> Solution:
    """``solution``, or a better fit of the same effects; an rms error of ``enough_deg`` suffices.

    Far from that, several effects are fitted at once as well, with k held at 1 at first, which load
    and friction can stand in for.
    """
    problem = solution.problem
    found = over_horizons(solution, enough_deg)
    several = len(problem.effects) >= SEVERAL and "k" not in problem.held
    if found.rmse_deg <= FAR * enough_deg or not several:
        return found
    gain = float(np.copysign(1.0, found.outcome.point[0]))
    unloaded = replace(problem, held={**problem.held, "k": gain})
    base = polish(unloaded.linear, [linear_start(unloaded.linear)])
    together = fit_together(unloaded, base, enough_deg)
    released = polish(problem, [together.outcome.point])
    return min(found, released, key=lambda one: one.outcome.cost)
