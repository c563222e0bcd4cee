"""Fits that start from the values of another model's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.identify.fit import Solution, fit_effects
from servosight.identify.problem import Problem
from servosight.identify.search import half_squares
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


def point_less(problem: Problem, fit: Solution) -> Array:
    """The search point of ``problem`` nearest to ``fit``, which has one effect more.

    The values of the fit, or those moved to where they make up for that effect to first order, as
    far as they can: whichever costs less. Friction at rest and friction that grows with the load
    can lie far along a valley, at whose other end there is the first alone.
    """
    places = {(one.name, one.recording): j for j, one in enumerate(fit.problem.coordinates)}
    kept = [places[one.name, one.recording] for one in problem.coordinates]
    gone = sorted(set(places.values()) - set(kept))
    # Where simulations fail a quotient may exceed all numbers, and tells nothing then.
    jacobian = np.nan_to_num(fit.jacobian, posinf=0.0, neginf=0.0)
    change = jacobian[:, gone] @ (fit.outcome.point - _neutral(fit))[gone]
    point = fit.outcome.point[kept]
    moved = point + np.linalg.lstsq(jacobian[:, kept], change, rcond=None)[0]
    points = np.clip([point, moved], *problem.bounds)
    return np.asarray(points[np.argmin(half_squares(problem.residuals(points)))])


def _neutral(fit: Solution) -> Array:
    """The fitted point, with all parameters that have a neutral value there."""
    pairs = zip(fit.problem.coordinates, fit.outcome.point, strict=True)
    neutral = (
        x if one.parameter.neutral is None else one.to_search(one.parameter.neutral)
        for one, x in pairs
    )
    return np.array(list(neutral))


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
