"""Fits of effects, from initial guesses that extend a fit without them."""

from __future__ import annotations

import numpy as np

from servosight.identify.fit._nested import contains, no_worse
from servosight.identify.fit._solution import POLISH_BUDGET, Solution, polish
from servosight.identify.problem import (
    Problem,
    effect_guesses,
    effect_starts,
    linear_start,
    neutral_start,
    score_directions,
)
from servosight.identify.search import half_squares
from servosight.models.core import Array

SKETCH_BUDGET = 60
WORSE = 1.02
"""A sketch whose cost is above this multiple of its base's is tried again from another start."""
POLISHED_STARTS = 3
SEARCHED_STARTS = 24
SHRUNK = (0.5, 0.25)
"""Guesses may be far too strong: these shares of their distance from neutral are starts as well."""
VARIED_STARTS = 96
"""Number of variations of the guesses, of which those of lowest cost are starts."""
VARIED_BY = 0.6
"""Standard deviation of these variations on a logarithmic scale."""


def fit_effects(
    problem: Problem,
    base: Solution | None = None,
    sketch: Solution | None = None,
    budget: int = POLISH_BUDGET,
) -> Solution:
    """Fit the problem's effects from initial guesses that extend a fit without some of them.

    ``base`` is that fit, the linear one where it is not given. A ``sketch`` of the same problem is
    one more start.
    """
    if base is None:
        base = polish(problem.linear, [linear_start(problem.linear)])
    if not problem.effects:
        return base
    starts = _starts(problem, base)[:POLISHED_STARTS]
    if sketch is not None:
        starts = np.vstack([sketch.outcome.point, starts[1:]])
    fit = polish(problem, starts, budget)
    return no_worse(fit, base, budget) if contains(fit, base) else fit


def sketch_effects(problem: Problem, base: Solution) -> Solution:
    """A rough fit that extends ``base``, from the best start: an estimate of its gain.

    Where the cost rises above the base's, the next best starts are tried.
    """
    sketches: list[Solution] = []
    for start in _starts(problem, base)[:POLISHED_STARTS]:
        sketches.append(polish(problem, [start], SKETCH_BUDGET))
        if sketches[-1].outcome.cost <= WORSE * base.outcome.cost:
            break
    return min(sketches, key=lambda sketch: sketch.outcome.cost)


def search_effects(problem: Problem, base: Solution) -> Solution:
    """Fit from many more starts than usual: for a cost as rugged as that of stick-slip.

    Seeded variations of the guesses are starts as well: several parameters of an effect can be
    guessed wrong at the same time.
    """
    guesses = np.array(effect_starts(problem, base.as_base))
    starts = np.vstack([guesses, _variations(problem, base, guesses)])
    starts = _ordered(starts, _costs(problem, base, starts)[1])
    return polish(problem, starts[:SEARCHED_STARTS])


def initial_changes(problem: Problem, base: Solution) -> Array:
    """How guesses of the effects that ``base`` lacks change its residual, (starts, scored).

    Their costs are kept with the base model, for fits that start there.
    """
    starts = np.array(effect_starts(problem, base.as_base))
    changes, costs = _costs(problem, base, starts)
    base.as_base.changes[problem.effects] = problem.masks, starts, costs
    return changes


def _starts(problem: Problem, base: Solution) -> Array:
    """The effects' guesses and weaker ones, (starts, coordinates), lowest cost first."""
    known = base.as_base.ordered
    made_for, starts = known.get(problem.effects, (None, None))
    if starts is None or made_for is not problem.masks:
        cached = base.as_base.changes
        if problem.effects not in cached or cached[problem.effects][0] is not problem.masks:
            initial_changes(problem, base)
        _, guesses, costs = cached[problem.effects]
        neutral = neutral_start(problem, base.as_base)
        plain = np.array(effect_guesses(problem, base.as_base))
        weaker = np.vstack([neutral + share * (plain - neutral) for share in SHRUNK])
        _, more = _costs(problem, base, weaker)
        starts = _ordered(np.vstack([guesses, weaker]), np.hstack([costs, more]))
        known[problem.effects] = problem.masks, starts
    return starts


def _variations(problem: Problem, base: Solution, guesses: Array) -> Array:
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


def _costs(problem: Problem, base: Solution, starts: Array) -> tuple[Array, Array]:
    """Changes (starts, scored) of the base's residual, and what starts cost, (2, starts).

    First what they cost as they are, then what they would cost at best with their change scaled: a
    guess of a period may be right and its amplitude wrong.
    """
    answers = problem.residuals(starts)
    changes = answers - base.residual
    _, gain = score_directions(changes, base.residual, base.jacobian)
    costs = half_squares(answers)
    scaled = base.outcome.cost - 0.5 * np.maximum(gain, 0.0) ** 2
    return changes, np.stack([costs, np.minimum(costs, scaled)])


def _ordered(starts: Array, costs: Array) -> Array:
    """Starts in turn by what they would cost scaled, and by what they cost."""
    unscaled, scaled = costs
    both = np.stack([np.argsort(scaled), np.argsort(unscaled)], axis=1).ravel()
    _, first = np.unique(both, return_index=True)
    return np.asarray(starts[both[np.sort(first)]])
