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
from servosight.models.core import Array, Mask

POLISH_BUDGET = 4_000
"""Evaluations of one descent."""
FIRST_GENERATIONS = 3
"""Generations from each start, after which the best descent alone goes on."""
FEW_STARTS, KEPT = 4, 3
"""With more than four starts, one in three of the descents is kept after each generation."""
_MOVES = np.geomspace(1e-5, 0.1, 150)
"""Shares of their values by which discontinuous parameters are moved at random."""
_MOVED_STARTS = 3
"""Number of moved points at which descents begin: those of lowest cost."""
_DRAWS = 2
"""Number of times that such moves are drawn before a fit is taken for the best."""
_WIDE = 100.0
_SMOOTHED = 1_000.0
"""Steps of difference quotients, times this, reach across the jumps of a prediction: about 1 %."""
_SMOOTHED_BUDGET = 200
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


def ended(fit: Solution) -> Solution:
    """``fit``, to its end where its budget was spent."""
    return polish(fit.problem, [fit.outcome.point]) if fit.out_of_budget else fit


def polish(problem: Problem, starts: Iterable[Array], budget: int = POLISH_BUDGET) -> Solution:
    """Descend from each start for a few generations, then to the end from the best.

    On a rugged cost it begins again from where it ended, until that gains nothing or all of it has
    come to ``POLISH_BUDGET``: far from a minimum a little is gained each time.
    """
    begun = problem.work.simulations
    if discontinuous(problem).any():
        starts = _smoothed(problem, starts, min(budget, _SMOOTHED_BUDGET))
    fit = _from_best(problem, starts, budget)
    for _ in problem.coordinates:
        spent = problem.work.simulations - begun >= POLISH_BUDGET
        better = None if fit.out_of_budget or spent else _better(fit)
        if better is None:
            break
        fit = better
    return fit


def _from_best(problem: Problem, starts: Iterable[Array], budget: int) -> Solution:
    descents = [_descent(problem, start) for start in starts]
    if len(descents) > FEW_STARTS:
        # What begins far above the others seldom passes them, and to follow it costs as much as to
        # follow the best (successive halving: Jamieson and Talwalkar 2016).
        for _ in range(FIRST_GENERATIONS):
            descents = _leading(problem, descents, -(-len(descents) // KEPT))
        descents = [descents[0].resumed()]
    elif len(descents) > 1:
        first = FIRST_GENERATIONS * (len(problem.coordinates) + 7)
        trials = [drive(descent, problem.residuals, first) for descent in descents]
        best = min(range(len(trials)), key=lambda i: trials[i].cost)
        descents = [descents[best].resumed()]
    return Solution(problem, drive(descents[0], problem.residuals, budget))


def _leading(
    problem: Problem, descents: Sequence[LevenbergMarquardt], count: int
) -> list[LevenbergMarquardt]:
    """The ``count`` best of some descents after one generation more, the best first."""
    costs = [_after_generation(problem, one) for one in descents]
    return [descents[i] for i in np.argsort(costs, kind="stable")[:count]]


def _after_generation(problem: Problem, descent: LevenbergMarquardt) -> float:
    """What a descent has come to after one generation more; one that has stopped stays there."""
    if descent.stopped is None:
        drive(descent, problem.residuals, len(problem.coordinates) + 7)
    return descent.cost


def _descent(problem: Problem, start: Array, wider: float = 0.0) -> LevenbergMarquardt:
    low, high = problem.bounds
    scale = coordinate_scale(problem, start)
    return LevenbergMarquardt(start, low, high, scale + wider * (scale + np.abs(start)))


def discontinuous(problem: Problem) -> Mask:
    """True for the coordinates with whose values a prediction jumps."""
    return np.array([one.parameter.discontinuous for one in problem.coordinates])


def _smoothed(problem: Problem, starts: Iterable[Array], budget: int) -> list[Array]:
    """Where descents end whose difference quotients reach across a prediction's jumps."""
    descents = [_descent(problem, start, _SMOOTHED) for start in starts]
    if len(descents) > FEW_STARTS:
        descents = _leading(problem, descents, FEW_STARTS)
    for descent in descents:
        if descent.stopped is None:
            drive(descent, problem.residuals, budget)
    return [descent.point for descent in descents]


def _better(fit: Solution) -> Solution | None:
    """A fit of lower cost, where a descent on a rugged cost ended early; None without one."""
    problem, outcome = fit.problem, fit.outcome
    neutral = _neutral(problem, outcome)
    if neutral is not None:
        return _from_best(problem, [neutral], POLISH_BUDGET)
    if not discontinuous(problem).any():
        return None
    for seed in range(_DRAWS):
        found = _from_best(problem, _moved(problem, outcome.point, seed), POLISH_BUDGET)
        if found.outcome.cost < _CLEARLY * outcome.cost:
            return found
    return None


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
    return _lowest(problem, trials, _LESS * outcome.cost)


def _moved(problem: Problem, point: Array, seed: int) -> Array:
    """Starts for discontinuous parameters: moved together, the rest following, (starts, all).

    The others go where the difference quotient has the prediction change least: one parameter
    alone seldom leaves a minimum that it shares with them.
    """
    moved = discontinuous(problem)
    wide = _WIDE * np.maximum(np.abs(point), 1.0 / _WIDE)
    # Where simulations fail a quotient may exceed all numbers, and tells nothing then.
    jacobian = np.nan_to_num(difference_quotient(problem, point, wide), posinf=0.0, neginf=0.0)
    drawn = np.random.default_rng(seed).normal(size=(_MOVES.size, int(moved.sum())))
    moves = np.zeros((_MOVES.size, point.size))
    moves[:, moved] = _MOVES[:, None] * drawn * point[moved]
    slopes = np.linalg.lstsq(jacobian[:, ~moved], jacobian[:, moved], rcond=None)[0]
    moves[:, ~moved] = -moves[:, moved] @ slopes.T
    points = np.clip(point + moves, *problem.bounds)
    costs = half_squares(problem.residuals(points))
    return np.asarray(points[np.argsort(costs)[:_MOVED_STARTS]])


def _lowest(problem: Problem, trials: Sequence[Array], below: float) -> Array | None:
    """Of some points the one that costs least, if that is less than ``below``."""
    if not trials:
        return None
    points = np.vstack(trials)
    costs = half_squares(problem.residuals(points))
    best = int(np.argmin(costs))
    return points[best] if costs[best] < below else None
