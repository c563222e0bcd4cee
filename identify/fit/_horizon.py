"""A fit repeated over growing horizons: out of the minima that friction, play and limits make."""

from __future__ import annotations

from dataclasses import replace

from servosight.identify.fit._solution import Solution, ended, polish

HORIZONS = (2.0, 4.0, 8.0)
"""Horizons in time constants T: over each the model predicts from the measured motion on."""
BUDGET = 150
"""Simulations of each fit over a horizon."""
FIRST_BUDGET = 400
"""Simulations of the fit to the whole recording, after which it is continued to its end only where
it is clearly better."""
CLEARLY = 0.9
"""A cost that is lower by this factor: 5 % of an rms error."""
ROUNDS = 3


def over_horizons(fit: Solution, enough_deg: float = 0.0) -> Solution:
    """``fit``, or a better one of the same effects.

    Each horizon's parameters begin the fit over the next longer one; the last is the whole
    recording. It is repeated from what was found as long as that is clearly better, until an rms
    error of ``enough_deg``. A plant that cannot begin anew on the way leaves ``fit`` as it is.
    """
    if not fit.problem.plant.restartable:
        return fit
    for _ in range(ROUNDS):
        if fit.rmse_deg <= enough_deg:
            break
        found = _once(fit)
        if found.outcome.cost >= CLEARLY * fit.outcome.cost:
            return min(fit, found, key=lambda one: one.outcome.cost)
        fit = ended(found)
    return fit


def _once(fit: Solution) -> Solution:
    problem, point = fit.problem, fit.outcome.point
    time_s = problem.values(point)["T"]
    for horizon in HORIZONS:
        near = replace(problem, horizon_s=horizon * time_s)
        point = polish(near, [point], BUDGET).outcome.point
    return polish(problem, [point], FIRST_BUDGET)
