"""Fits that start from the values of another model's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.identify.fit import Solution, fit_effects
from servosight.identify.problem import Problem
from servosight.models.core import Array
from servosight.models.effects import Effect


def point_of(problem: Problem, fit: Solution, names: Mapping[str, str] | None = None) -> Array:
    """The search point of ``problem`` with the values of ``fit``, which has all its parameters.

    ``names`` gives those that have another name there.
    """
    known = {
        (one.name, one.recording): (one, float(x))
        for one, x in zip(fit.problem.coordinates, fit.outcome.point, strict=True)
    }
    point = []
    for own in problem.coordinates:
        there = own.name if names is None else names.get(own.name, own.name)
        other, x = known[there, own.recording]
        point.append(x if there == own.name else own.to_search(other.from_search(x)))
    return np.array(point)


def fit_special(
    problem: Problem, left: Solution, base: Solution, effect: Effect, special: Effect, budget: int
) -> Solution:
    """A fit of ``problem``: ``left`` and a special case of an effect that ``base`` has beside that.

    The values of ``base``, which has all of the effect's parameters, are one start: those of a
    special case come first in the effect that contains it.
    """
    pairs = zip(special.parameters, effect.parameters, strict=False)
    names = {f"{special.id}.{own.name}": f"{effect.id}.{other.name}" for own, other in pairs}
    point = np.clip(point_of(problem, base, names), *problem.bounds)
    return fit_effects(problem, left, Solution.at(problem, point), budget)
