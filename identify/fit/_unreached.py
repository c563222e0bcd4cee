"""Limits that a fit never reaches, tried at values at which they act.

Where a limit is not reached no slope leads back to it: a lag, a weight or friction has taken its
place, and all of these are wrong. So the limit is held at a few values below what the model asks
for, the rest is fitted to each, and then all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from servosight.identify.fit._horizon import CLEARLY, over_horizons
from servosight.identify.fit._solution import Solution, ended, polish
from servosight.identify.search import half_squares
from servosight.models.core import Array
from servosight.models.effects import Effect

SHARES = np.geomspace(8.0, 0.01, 60)
"""Limits are sought among so many shares of their guess,"""
ACTS = 1e-3
"""the largest that changes the cost by this share; tried are"""
BELOW = (0.85, 0.6, 0.4, 0.25)
"""so many times that,"""
HELD_BUDGET, FREE_BUDGET = 100, 150
"""with so many simulations while the limit is held, and then."""


def with_limits_reached(fit: Solution, enough_deg: float = 0.0) -> Solution:
    """``fit``, or a clearly better one of the same effects that reaches a limit which it does not.

    It ends at an rms error of ``enough_deg``.
    """
    for effect in unreached(fit) if fit.rmse_deg > enough_deg else ():
        begun = _begun(fit, effect, enough_deg)
        if begun is not None:
            found = over_horizons(begun, enough_deg)
            fit = ended(found) if found.outcome.cost < CLEARLY * fit.outcome.cost else fit
        if fit.rmse_deg <= enough_deg:
            break
    return fit


def unreached(fit: Solution) -> list[Effect]:
    """The limits without which the fit is about as good."""
    effects = fit.problem.plant.layout.effects
    limits = [one for one in effects if one.id in fit.problem.effects and _is_free(fit, one)]
    without = [_point_at(fit, _scaled(fit, effect, math.inf)) for effect in limits]
    if not limits:
        return []
    costs = half_squares(fit.problem.residuals(np.array(without)))
    most = fit.outcome.cost / CLEARLY
    return [effect for effect, cost in zip(limits, costs, strict=True) if cost < most]


def _limits(effect: Effect) -> list[bool]:
    """Which of an effect's parameters are limits, (parameters,)."""
    return [one.reciprocal and math.isinf(one.high) for one in effect.parameters]


def _is_free(fit: Solution, effect: Effect) -> bool:
    """True of an effect that vanishes as its limits grow, none of whose parameters are held."""
    held = any(f"{effect.id}.{one.name}" in fit.problem.held for one in effect.parameters)
    sizes = [one.neutral is not None for one in effect.parameters]
    limited = zip(_limits(effect), sizes, strict=True)
    return all(limit for limit, size in limited if size) and not held


def _begun(fit: Solution, effect: Effect, enough_deg: float) -> Solution | None:
    """The best fit from values at which a limit acts, as long as stronger ones are better."""
    best = None
    for values in _acting(fit, effect):
        found = _from(fit, values)
        if best is not None and found.outcome.cost > best.outcome.cost:
            break
        best = found
        if best.rmse_deg <= enough_deg:
            break
    return best


def _acting(fit: Solution, effect: Effect) -> Iterator[Mapping[str, float]]:
    """Values of an effect whose limits act, the weakest first; none where no guess acts."""
    tried = [_scaled(fit, effect, share) for share in (math.inf, *SHARES)]
    points = np.array([_point_at(fit, values) for values in tried])
    costs = half_squares(fit.problem.residuals(points))
    acts = np.abs(costs[1:] - costs[0]) > ACTS * costs[0]
    if acts.any():
        yield from (_scaled(fit, effect, float(SHARES[acts.argmax()]) * less) for less in BELOW)


def _scaled(fit: Solution, effect: Effect, share: float) -> Mapping[str, float]:
    """An effect's first guess with its limits scaled by ``share``."""
    guess = fit.as_base.guesses(effect)[0]
    return {
        f"{effect.id}.{parameter.name}": share * value if limit else value
        for parameter, value, limit in zip(effect.parameters, guess, _limits(effect), strict=True)
    }


def _point_at(fit: Solution, values: Mapping[str, float]) -> Array:
    """The search point of ``fit`` with some parameters at other values."""
    coordinates, (low, high) = fit.problem.coordinates, fit.problem.bounds
    point = fit.outcome.point.copy()
    for j, coordinate in enumerate(coordinates):
        if coordinate.name in values:
            point[j] = coordinate.to_search(values[coordinate.name])
    return np.asarray(np.clip(point, low, high))


def _from(fit: Solution, values: Mapping[str, float]) -> Solution:
    """All fitted from where the rest is fitted to some parameters held at ``values``."""
    problem = fit.problem
    holding = replace(problem, held={**problem.held, **values})
    held = polish(holding, [_point_at(fit, values)], HELD_BUDGET)
    return polish(problem, [held.outcome.point], FREE_BUDGET)
