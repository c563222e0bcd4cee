"""Limits that a fit never reaches, tried at values at which they act.

Where a limit is not reached no slope leads back to it: a lag, a weight or friction has taken its
place, and all of these are wrong. So the limit is held at a few values below what the model asks
for, the rest is fitted to each, and then all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit._horizon import CLEARLY, over_horizons
from servosight.identify.fit._solution import Solution, ended, polish
from servosight.identify.search import half_squares
from servosight.models.core import Array
from servosight.models.effects import Effect

SHARES = np.geomspace(8.0, 0.01, 60)
"""Shares of a limit's first guess at which the cost is computed, from the largest down."""
ACTS = 1e-3
"""A limit acts from the largest share at which it changes the cost by at least this share."""
BELOW = (0.85, 0.6, 0.4, 0.25)
"""The fits begin with the limit at these shares of the value at which it begins to act."""
HELD_BUDGET, FREE_BUDGET = 100, 150
"""Simulations of a fit while the limit is held, and of the next one, in which it is free."""


@dataclass(frozen=True)
class Limits:
    """An effect with limits, or one of several limits of an effect; ``names`` are those that a fit
    may not reach."""

    effect: Effect
    names: tuple[str, ...]

    def scaled(self, fit: Solution, share: float) -> Mapping[str, float]:
        """The effect's first guess with the limits scaled by ``share``; of an effect that remains
        without them, and of one limit of several, the limit alone, all else as it is fitted."""
        guess = zip(self.effect.parameters, fit.as_base.guesses(self.effect)[0], strict=True)
        whole = self.names == _names(self.effect) and _vanishes(self.effect)
        return {
            f"{self.effect.id}.{one.name}": share * value if one.name in self.names else value
            for one, value in guess
            if whole or one.name in self.names
        }


def with_limits_reached(fit: Solution, enough_deg: float = 0.0) -> Solution:
    """``fit``, or a clearly better one of the same effects that reaches a limit which it does not.

    It ends at an rms error of ``enough_deg``.
    """
    for limits in unreached(fit) if fit.rmse_deg > enough_deg else ():
        begun = _begun(fit, limits, enough_deg)
        if begun is not None:
            found = over_horizons(begun, enough_deg)
            fit = ended(found) if found.outcome.cost < CLEARLY * fit.outcome.cost else fit
        if fit.rmse_deg <= enough_deg:
            break
    return fit


def unreached(fit: Solution) -> list[Limits]:
    """The limits without which the fit is about as good."""
    effects = fit.problem.plant.layout.effects
    free = [one for one in effects if one.id in fit.problem.effects and _is_free(fit, one)]
    limits = [one for effect in free for one in _limits(effect)]
    if not limits:
        return []
    without = [_point_at(fit, one.scaled(fit, math.inf)) for one in limits]
    costs = half_squares(fit.problem.residuals(np.array(without)))
    most = fit.outcome.cost / CLEARLY
    return [one for one, cost in zip(limits, costs, strict=True) if cost < most]


def _names(effect: Effect) -> tuple[str, ...]:
    """Which of an effect's parameters are limits."""
    return tuple(one.name for one in effect.parameters if one.reciprocal and math.isinf(one.high))


def _limits(effect: Effect) -> Iterator[Limits]:
    """All limits of an effect together, and each of several: slow moves reach the acceleration of a
    profile and not its speed."""
    names = _names(effect)
    yield Limits(effect, names)
    if len(names) > 1:
        yield from (Limits(effect, (name,)) for name in names)


def _is_free(fit: Solution, effect: Effect) -> bool:
    """True of an effect with limits, none of whose parameters are held."""
    held = any(f"{effect.id}.{one.name}" in fit.problem.held for one in effect.parameters)
    return bool(_names(effect)) and not held


def _vanishes(effect: Effect) -> bool:
    """True where nothing of the effect is left as its limits grow."""
    sizes = {one.name for one in effect.parameters if one.neutral is not None}
    return sizes <= set(_names(effect))


def _begun(fit: Solution, limits: Limits, enough_deg: float) -> Solution | None:
    """The best fit from values at which a limit acts, as long as stronger ones are better."""
    best = None
    for values in _acting(fit, limits):
        found = _from(fit, values)
        if best is not None and found.outcome.cost > best.outcome.cost:
            break
        best = found
        if best.rmse_deg <= enough_deg:
            break
    return best


def _acting(fit: Solution, limits: Limits) -> Iterator[Mapping[str, float]]:
    """Values at which limits act, the weakest first; none where no guess acts."""
    tried = [limits.scaled(fit, share) for share in (math.inf, *SHARES)]
    points = np.array([_point_at(fit, values) for values in tried])
    costs = half_squares(fit.problem.residuals(points))
    acts = np.abs(costs[1:] - costs[0]) > ACTS * costs[0]
    if acts.any():
        yield from (limits.scaled(fit, float(SHARES[acts.argmax()]) * less) for less in BELOW)


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
