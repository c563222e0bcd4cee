"""Solutions of a fit problem: descents from several starts, restarted where they end early."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.identify.problem import BaseModel, Problem, coordinate_scale, difference_quotient
from servosight.identify.search import (
    NOT_FITTED,
    LevenbergMarquardt,
    Outcome,
    StopReason,
    drive,
    half_squares,
)
from servosight.identify.uncertainty import Uncertainty
from servosight.models.core import Array

POLISH_BUDGET = 4_000
"""Evaluations of one descent."""
FIRST_GENERATIONS = 3
"""Generations from each start, after which the best descent alone goes on."""
_PERTURBATIONS = np.outer([-1.0, 1.0], np.geomspace(1e-5, 0.1, 40)).ravel()
_CLEARLY = 0.999
_LESS = 1.0 - 1e-9  # a smaller gain is rounding


@dataclass(frozen=True)
class Solution:
    """A problem and the point that solves it, with how the search ended.

    ``notes`` are sentences on how the fit was reached, for its user.
    """

    problem: Problem
    outcome: Outcome
    notes: tuple[str, ...] = ()

    @classmethod
    def at(cls, problem: Problem, point: Array) -> Solution:
        """A point that was found otherwise, evaluated and not fitted."""
        cost = float(half_squares(problem.residuals(point[None, :]))[0])
        return cls(problem, Outcome(point, cost, 1, NOT_FITTED, np.array([cost]), point[None, :]))

    @property
    def out_of_budget(self) -> bool:
        """True where the search ended because its budget was used up."""
        return self.outcome.stopped.reason is StopReason.BUDGET

    @cached_property
    def residual(self) -> Array:
        """Weighted residual of the scored samples at the point, (scored,)."""
        return np.asarray(self.problem.residuals(self.outcome.point[None, :])[0])

    @cached_property
    def jacobian(self) -> Array:
        """Of the residuals at the point, (scored, coordinates)."""
        point = self.outcome.point
        return difference_quotient(self.problem, point, coordinate_scale(self.problem, point))

    @cached_property
    def as_base(self) -> BaseModel:
        """The fitted model from which fits with more effects start."""
        return BaseModel(self.problem, self.outcome.point)

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """The uncertainty of the point."""
        return Uncertainty(self.problem, self.outcome.point, self.jacobian, self.outcome.cost)

    @property
    def rmse_deg(self) -> float:
        """Rms of the weighted residuals of the scored samples [deg]."""
        scored = sum(int(mask.sum()) for mask in self.problem.masks)
        return float(np.sqrt(2.0 * self.outcome.cost / scored))


def polish(problem: Problem, starts: Iterable[Array], budget: int = POLISH_BUDGET) -> Solution:
    """Descend from each start for a few generations, then to the end from the best."""
    descents = [_descent(problem, start) for start in starts]
    if len(descents) > 1:
        first = FIRST_GENERATIONS * (len(problem.coordinates) + 7)
        trials = [drive(descent, problem.residuals, first) for descent in descents]
        best = min(range(len(trials)), key=lambda i: trials[i].cost)
        descents = [descents[best].resumed()]
    fit = Solution(problem, drive(descents[0], problem.residuals, budget))
    for _ in problem.coordinates:
        better = None if fit.out_of_budget else _better(fit)
        if better is None:
            break
        fit = Solution(problem, drive(_descent(problem, better), problem.residuals, POLISH_BUDGET))
    return fit


def _descent(problem: Problem, start: Array) -> LevenbergMarquardt:
    low, high = problem.bounds
    return LevenbergMarquardt(start, low, high, coordinate_scale(problem, start))


def _better(fit: Solution) -> Array | None:
    """A point with a lower cost, where a descent on a rugged cost ended early; None without one."""
    neutral = _neutral(fit.problem, fit.outcome)
    return neutral if neutral is not None else _perturbed(fit.problem, fit.outcome)


def _neutral(problem: Problem, outcome: Outcome) -> Array | None:
    """The point with one effect's parameter at its neutral bound, where that costs less.

    Near neutral the cost of backlash and friction is rugged, and a descent stops before it.
    """
    low, high = problem.bounds
    trials = []
    for j, coordinate in enumerate(problem.coordinates):
        neutral = coordinate.parameter.neutral
        if neutral is None or outcome.point[j] == (bound := coordinate.to_search(neutral)):
            continue
        if bound in (low[j], high[j]):
            trials.append(outcome.point.copy())
            trials[-1][j] = bound
    return _cheapest(problem, trials, _LESS * outcome.cost)


def _perturbed(problem: Problem, outcome: Outcome) -> Array | None:
    """The point with one discontinuous parameter changed a little, if that costs clearly less."""
    trials = []
    for j, coordinate in enumerate(problem.coordinates):
        if coordinate.parameter.jumpy:
            moved = np.tile(outcome.point, (_PERTURBATIONS.size, 1))
            moved[:, j] *= 1.0 + _PERTURBATIONS
            trials.append(np.clip(moved, *problem.bounds))
    return _cheapest(problem, trials, _CLEARLY * outcome.cost)


def _cheapest(problem: Problem, trials: Sequence[Array], below: float) -> Array | None:
    """Of some points the one that costs least, if that is less than ``below``."""
    if not trials:
        return None
    points = np.vstack(trials)
    costs = half_squares(problem.residuals(points))
    best = int(np.argmin(costs))
    return points[best] if costs[best] < below else None
