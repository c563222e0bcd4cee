"""From a problem to its solution: descents from physical starts, behind a fit with less."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.identify.problem import (
    Problem,
    Standpoint,
    directions,
    effect_guesses,
    effect_starts,
    idle_start,
    linear_start,
)
from servosight.identify.search import GaussNewton, Outcome, drive, half_squares
from servosight.models.core import Array

POLISH_BUDGET = 4_000
SKETCH_BUDGET = 60
ASTRAY = 1.02
POLISHED_STARTS = 3
SEARCHED_STARTS = 24
SHRUNK = (0.5, 0.25)
"""Guesses may be far too strong: these shares of their distance from neutral are starts as well."""
VARIED_STARTS = 96
"""Variations of the guesses, of which the most promising are searched from;"""
VARIED_BY = 0.6
"""T, xi and the effects' own numbers are off by about so much, on a logarithmic scale."""
HEAT_GENERATIONS = 3
_COMB = np.outer([-1.0, 1.0], np.geomspace(1e-5, 0.1, 40)).ravel()
_COMBED = 0.999
_LESS = 1.0 - 1e-9  # a smaller gain is rounding


@dataclass(frozen=True)
class Fit:
    """A problem solved: the point and how the search ended."""

    problem: Problem
    outcome: Outcome

    @property
    def spent(self) -> bool:
        """True where the fit ended for want of budget."""
        return self.outcome.stopped.startswith("budget")

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
    def standpoint(self) -> Standpoint:
        """From which fits with more effects start."""
        return Standpoint(self.problem, self.outcome.point)

    @property
    def rmse_deg(self) -> float:
        """Rms of the weighted residuals of the scored samples [deg]."""
        scored = sum(int(mask.sum()) for mask in self.problem.masks)
        return float(np.sqrt(2.0 * self.outcome.cost / scored))


def polish(problem: Problem, starts: Iterable[Array], budget: int = POLISH_BUDGET) -> Fit:
    """Gauss-Newton from each start for a few generations, then to the end from the best."""
    descents = [_descent(problem, start) for start in starts]
    if len(descents) > 1:
        heat = HEAT_GENERATIONS * (len(problem.coordinates) + 7)
        heats = [drive(descent, problem.residuals, heat) for descent in descents]
        best = min(range(len(heats)), key=lambda i: heats[i].cost)
        descents = [descents[best].resumed()]
    fit = Fit(problem, drive(descents[0], problem.residuals, budget))
    for _ in problem.coordinates:
        better = None if fit.spent else _better(fit)
        if better is None:
            break
        fit = Fit(problem, drive(_descent(problem, better), problem.residuals, POLISH_BUDGET))
    return fit


def _descent(problem: Problem, start: Array) -> GaussNewton:
    low, high = problem.bounds
    return GaussNewton(start, low, high, coordinate_scale(problem, start))


def _better(fit: Fit) -> Array | None:
    """A point from which it goes further down, as descents end early on rugged costs."""
    idle = _idle(fit.problem, fit.outcome)
    return idle if idle is not None else _combed(fit.problem, fit.outcome)


def _idle(problem: Problem, outcome: Outcome) -> Array | None:
    """The point with one effect's parameter at its neutral bound, where that costs less.

    Near neutral the cost of play and friction is rugged, and a descent stops short of it.
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


def _combed(problem: Problem, outcome: Outcome) -> Array | None:
    """The point with one jumpy parameter moved a little or less, where that costs clearly less."""
    trials = []
    for j, coordinate in enumerate(problem.coordinates):
        if coordinate.parameter.jumpy:
            moved = np.tile(outcome.point, (_COMB.size, 1))
            moved[:, j] *= 1.0 + _COMB
            trials.append(np.clip(moved, *problem.bounds))
    return _cheapest(problem, trials, _COMBED * outcome.cost)


def _cheapest(problem: Problem, trials: Sequence[Array], below: float) -> Array | None:
    """Of some points the one that costs least, if that is less than ``below``."""
    if not trials:
        return None
    points = np.vstack(trials)
    costs = half_squares(problem.residuals(points))
    best = int(np.argmin(costs))
    return points[best] if costs[best] < below else None


def coordinate_scale(problem: Problem, point: Array) -> Array:
    """Size of a meaningful change of each coordinate."""
    scale = np.ones(point.size)
    for j, coordinate in enumerate(problem.coordinates):
        low, high = coordinate.bounds
        scale[j] = min(1.0, high - low) if not coordinate.logarithmic else 1.0
        if coordinate.parameter.unit == "s" and not coordinate.logarithmic:
            scale[j] = 0.05
        if coordinate.parameter.reciprocal:
            scale[j] = max(abs(point[j]), 1e-4)
    return scale


def difference_quotient(problem: Problem, point: Array, scale: Array) -> Array:
    """Central difference Jacobian of the residuals, (scored, coordinates)."""
    low, high = problem.bounds
    steps = 1e-4 * (scale + np.abs(point))
    up = np.clip(point + np.diag(steps), low, high)
    down = np.clip(point - np.diag(steps), low, high)
    answers = problem.residuals(np.vstack([up, down]))
    width = np.diag(up) - np.diag(down)
    count = point.size
    return np.asarray(((answers[:count] - answers[count:]) / width[:, None]).T)


def fit_effects(
    problem: Problem,
    base: Fit | None = None,
    sketch: Fit | None = None,
    budget: int = POLISH_BUDGET,
) -> Fit:
    """Fit the problem's effects from their physical starts behind a fit without some of them.

    A ``sketch`` of the same problem is one start more.
    """
    if base is None:
        linear = Problem(problem.recordings, problem.plant, (), problem.masks)
        base = polish(linear, [linear_start(linear)])
    if not problem.effects:
        return base
    starts = _starts(problem, base)[:POLISHED_STARTS]
    if sketch is not None:
        starts = np.vstack([sketch.outcome.point, starts[1:]])
    fit = polish(problem, starts, budget)
    nested = set(base.problem.effects) <= set(problem.effects)
    if not nested or fit.outcome.cost <= base.outcome.cost:
        return fit
    # All starts led astray: begin where the new effect does nothing, and cannot cost more.
    return polish(problem, [idle_start(problem, base.standpoint)], budget)


def sketch_effects(problem: Problem, base: Fit) -> Fit:
    """A rough fit behind ``base``, from the best start: enough to see where it leads.

    Where that leads up, the next best are tried.
    """
    sketches: list[Fit] = []
    for start in _starts(problem, base)[:POLISHED_STARTS]:
        sketches.append(polish(problem, [start], SKETCH_BUDGET))
        if sketches[-1].outcome.cost <= ASTRAY * base.outcome.cost:
            break
    return min(sketches, key=lambda sketch: sketch.outcome.cost)


def search_effects(problem: Problem, base: Fit) -> Fit:
    """Fit from many more starts than usual: for a cost as rugged as stick-slip makes it.

    Beside the guesses stand seeded variations of them: several numbers of an effect can be guessed
    wrong at once.
    """
    guesses = np.array(effect_starts(problem, base.standpoint))
    starts = np.vstack([guesses, _varied(problem, base, guesses)])
    starts = _in_order(starts, _weighed(problem, base, starts)[1])
    return polish(problem, starts[:SEARCHED_STARTS])


def first_look(problem: Problem, base: Fit) -> Array:
    """How the guesses of what ``base`` lacks change its residual, (starts, scored).

    What they promise is kept with the base's standpoint, for fits that start there.
    """
    starts = np.array(effect_starts(problem, base.standpoint))
    changes, promise = _weighed(problem, base, starts)
    base.standpoint.looks[problem.effects] = problem.masks, starts, promise
    return changes


def _starts(problem: Problem, base: Fit) -> Array:
    """The effects' guesses and weaker ones, (starts, coordinates), the most promising first."""
    known = base.standpoint.ordered
    made_for, starts = known.get(problem.effects, (None, None))
    if starts is None or made_for is not problem.masks:
        looks = base.standpoint.looks
        if problem.effects not in looks or looks[problem.effects][0] is not problem.masks:
            first_look(problem, base)
        _, guesses, promise = looks[problem.effects]
        idle = idle_start(problem, base.standpoint)
        plain = np.array(effect_guesses(problem, base.standpoint))
        weaker = np.vstack([idle + share * (plain - idle) for share in SHRUNK])
        _, more = _weighed(problem, base, weaker)
        starts = _in_order(np.vstack([guesses, weaker]), np.hstack([promise, more]))
        known[problem.effects] = problem.masks, starts
    return starts


def _varied(problem: Problem, base: Fit, guesses: Array) -> Array:
    """Seeded variations of guesses, (VARIED_STARTS, coordinates)."""
    kept = {c.name for c in base.problem.coordinates} - {"T", "xi"}
    rng = np.random.default_rng(0)
    points = guesses[np.arange(VARIED_STARTS) % len(guesses)]
    for j, coordinate in enumerate(problem.coordinates):
        if coordinate.name in kept:
            continue
        off = VARIED_BY * rng.normal(size=VARIED_STARTS)
        points[:, j] = points[:, j] + off if coordinate.logarithmic else points[:, j] * np.exp(off)
    return np.clip(points, *problem.bounds)


def _weighed(problem: Problem, base: Fit, starts: Array) -> tuple[Array, Array]:
    """Changes (starts, scored) of the base's residual, and what starts cost, (2, starts).

    First what they cost as they are, then what they would cost at best with their change scaled: a
    guess of a period may be right and its amplitude wrong.
    """
    answers = problem.residuals(starts)
    changes = answers - base.residual
    _, reach = directions(changes, base.residual, base.jacobian)
    costs = half_squares(answers)
    scaled = base.outcome.cost - 0.5 * np.maximum(reach, 0.0) ** 2
    return changes, np.stack([costs, np.minimum(costs, scaled)])


def _in_order(starts: Array, promise: Array) -> Array:
    """Starts in turn by what they would cost scaled, and by what they cost."""
    costs, scaled = promise
    both = np.stack([np.argsort(scaled), np.argsort(costs)], axis=1).ravel()
    _, first = np.unique(both, return_index=True)
    return np.asarray(starts[both[np.sort(first)]])
