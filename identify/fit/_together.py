"""Several effects fitted at once, from starts spread over all that a servo could be.

With each of them missing a servo of many effects is so far from its model that neither the fitted T
and xi nor the guesses of one effect are a start for the next: descents one after the other end in
the nearest minimum. A few hundred simulations of points drawn at random find the valley of the
right one more often than not, and cost less than one descent.
"""

from __future__ import annotations

from collections.abc import Iterable
from zlib import crc32

import numpy as np

from servosight.identify.fit._horizon import CLEARLY, over_horizons
from servosight.identify.fit._solution import Solution, ended, polish
from servosight.identify.fit._unreached import with_limits_reached
from servosight.identify.problem import Problem, neutral_start
from servosight.identify.search import half_squares
from servosight.models.core import Array

POINTS = 600
"""Number of points that are drawn and simulated."""
STARTS = 8
"""Number of these points at which descents begin: those of lowest cost."""
FIRST_BUDGET = 150
"""Simulations of each of these descents, after which they are compared."""
FINISHED = 3
"""Number of descents that are continued to their end: those of lowest cost."""
SPAN_T_S = (0.005, 0.2)
SPAN_XI = (0.1, 1.5)
ABSENT = 0.3
"""Share of the points in which an effect is neutral."""
SPAN_SHARE = (0.05, 1.5)
"""Range of the factor by which an effect's guess is multiplied in the other points."""
VARIED_POINTS = 200
"""Number of variations of a fit that are simulated in a round."""
VARIED_STARTS = 4
"""Number of variations at which short descents begin; the best of these is continued."""
VARIED_BY = 0.25
"""Standard deviation of the variations on a logarithmic scale, itself varied by a factor of two."""
FAR = 10.0
"""A fit is varied only if its error is below this multiple of the error that would be enough. At 4
an XL330's lower minimum was missed; at 12 and more a servo's variations took what single steps may
cost."""
ROUNDS, IN_VAIN = 5, 2
"""Rounds of variations at the most, and how many in a row may lower nothing."""


def fit_together(
    problem: Problem, base: Solution, enough_deg: float = 0.0, most_deg: float = np.inf,
    most_cost: float = np.inf,
) -> Solution:  # fmt: skip
    """Fit the effects that ``base`` lacks at once; its T, xi and bias are no start.

    An rms error of ``enough_deg`` ends the search. Limits that the best fit does not reach are
    tried where they act, whatever that costs. A fit that ends above ``FAR`` times as much is not
    varied, nor one above ``most_deg``, which another model reaches: what it lacks is an effect, not
    a lower minimum. Once all simulations have come to ``most_cost``, no more starts are followed to
    their end, and nothing is varied.
    """
    begun = _begun(problem, *centred(problem, spread(problem, base)), STARTS)
    fit = _first_enough(map(ended, begun[:FINISHED]), enough_deg, most_cost)
    fit = with_limits_reached(fit, enough_deg)
    far = 0.0 < FAR * enough_deg < fit.rmse_deg or fit.rmse_deg > most_deg
    return fit if far else fit_varied(fit, enough_deg, most_cost)


def fit_varied(fit: Solution, enough_deg: float = 0.0, most_cost: float = np.inf) -> Solution:
    """``fit``, or a better one of the same effects: over growing horizons, and from seeded
    variations of all its parameters.

    Stick-slip, play and limits leave many minima side by side, and each step to a lower one shows
    the next. It ends where nothing is gained, at an rms error of ``enough_deg``, or where all
    simulations, those before it as well, have come to ``most_cost`` (``Work``).
    """
    work, in_vain = fit.problem.work, 0
    if work.cost >= most_cost:
        return ended(fit)
    fit = over_horizons(fit, enough_deg)
    for seed in range(ROUNDS):
        if fit.rmse_deg <= enough_deg or in_vain == IN_VAIN or work.cost >= most_cost:
            break
        points = _variations(fit, seed)
        costs = half_squares(fit.problem.residuals(points))
        varied = _begun(fit.problem, points, costs, VARIED_STARTS)[0]
        best = over_horizons(varied, enough_deg)
        in_vain = 0 if best.outcome.cost < CLEARLY * fit.outcome.cost else in_vain + 1
        fit = min(fit, best, key=_cost)
    return ended(fit)


def _begun(problem: Problem, points: Array, costs: Array, starts: int) -> list[Solution]:
    """Short descents from those of lowest cost of ``points``, the best first."""
    found = [polish(problem, [points[i]], FIRST_BUDGET) for i in np.argsort(costs)[:starts]]
    return sorted(found, key=_cost)


def _first_enough(fits: Iterable[Solution], enough_deg: float, most_cost: float) -> Solution:
    """The first fit whose error is ``enough_deg`` at the most, or else the best of all that were
    made before all simulations came to ``most_cost``."""
    seen: list[Solution] = []
    for fit in fits:
        seen.append(fit)
        if fit.rmse_deg <= enough_deg or fit.problem.work.cost >= most_cost:
            break
    return min(seen, key=_cost)


def _cost(fit: Solution) -> float:
    return fit.outcome.cost


def _variations(fit: Solution, seed: int) -> Array:
    """Search points about a fit: its effects' parameters, T and xi by factors, k as it is."""
    problem, rng = fit.problem, np.random.default_rng(seed)
    points = np.tile(fit.outcome.point, (VARIED_POINTS, 1))
    size = VARIED_BY * np.exp(0.7 * rng.normal(size=VARIED_POINTS))
    for j, coordinate in enumerate(problem.coordinates[1 : problem.physical], start=1):
        off = size * rng.normal(size=VARIED_POINTS)
        points[:, j] = points[:, j] + off if coordinate.logarithmic else points[:, j] * np.exp(off)
    return np.clip(points, *problem.bounds)


def spread(problem: Problem, base: Solution, seed: int = 0) -> Array:
    """Search points drawn over T, xi and the effects that ``base`` lacks, (points, coordinates).

    Each effect is absent, or has one of its guesses times a share; k is that of ``base`` or 1. What
    is drawn for an effect depends on its name, and not on what else a catalogue holds.
    """
    rng = np.random.default_rng(seed)
    neutral = neutral_start(problem, base.as_base)
    points = np.tile(neutral, (POINTS, 1))
    points[::2, 0] = np.copysign(1.0, neutral[0])
    points[:, 1] = _drawn(rng, SPAN_T_S)
    points[:, 2] = _drawn(rng, SPAN_XI)
    lacked = set(problem.effects) - set(base.problem.effects)
    for effect in (one for one in problem.plant.layout.effects if one.id in lacked):
        own = np.random.default_rng([seed, crc32(effect.id.encode())])
        guesses = np.array(base.as_base.guesses(effect))
        drawn = guesses[own.integers(len(guesses), size=POINTS)]
        share = np.exp(_drawn(own, SPAN_SHARE))
        present = own.random(POINTS) >= ABSENT
        for value, parameter in zip(drawn.T, effect.parameters, strict=True):
            name = f"{effect.id}.{parameter.name}"
            for j, coordinate in enumerate(problem.coordinates):
                if coordinate.name != name:
                    continue
                guess = np.array([coordinate.to_search(float(one)) for one in value])
                scaled = neutral[j] + share * (guess - neutral[j])
                points[present, j] = scaled[present]
    _place(problem, points)
    return np.clip(points, *problem.bounds)


def _drawn(rng: np.random.Generator, span: tuple[float, float]) -> Array:
    """Logarithms of numbers in ``span``, drawn evenly, (points,)."""
    low, high = span
    return rng.uniform(np.log(low), np.log(high), POINTS)


def _place(problem: Problem, points: Array) -> None:
    """Each recording's bias, first angle and first speed, for models that were not fitted."""
    for r, recording in enumerate(problem.recordings):
        own = problem.physical + 3 * r
        command = recording.command_at(recording.time_s)
        points[:, own] = np.mean(recording.angle_deg) - points[:, 0] * np.mean(command)
        points[:, own + 1 : own + 3] = recording.angle_deg[0], 0.0


def centred(problem: Problem, points: Array) -> tuple[Array, Array]:
    """Search points (points, coordinates) with each bias moved by the mean error of its recording
    where that leaves less, and their costs (points,).

    Weight, friction and limits keep a servo's mean angle from where k and the mean command have it
    by far more than its bias is: each point by another amount, which its simulation shows.
    """
    ends = np.cumsum([int(mask.sum()) for mask in problem.masks])[:-1]
    before = np.split(problem.residuals(points), ends, axis=1)
    columns = problem.physical + 3 * np.arange(len(before))
    moved = points.copy()
    moved[:, columns] += np.stack([errors.mean(axis=1) for errors in before], axis=1)
    moved = np.clip(moved, *problem.bounds)
    after = np.split(problem.residuals(moved), ends, axis=1)
    once, now = (np.stack([half_squares(one) for one in each], 1) for each in (before, after))
    moved[:, columns] = np.where(now < once, moved[:, columns], points[:, columns])
    return moved, np.minimum(now, once).sum(axis=1)
