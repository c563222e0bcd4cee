"""A fit cannot be worse than that of a model which it contains: where it is, it is done again.

With its further effects at neutral a model predicts what the contained one does, so the least cost
of the larger is at most the least cost of the smaller. A fit that ends above that has ended in a
local minimum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.fit._solution import POLISH_BUDGET, Solution, polish
from servosight.identify.problem import neutral_start

_ROUNDING = 1.0 + 1e-9


def contains(fit: Solution, smaller: Solution) -> bool:
    """True where ``smaller`` fits the same samples with some of the effects of ``fit``.

    Not where a parameter that the others lack is held away from neutral, nor where one that they
    fit is held.
    """
    mine, other = fit.problem, smaller.problem
    alike = len(mine.recordings) == len(other.recordings) and all(
        a is b and np.array_equal(m, n)
        for a, b, m, n in zip(
            mine.recordings, other.recordings, mine.masks, other.masks, strict=True
        )
    )
    further = {c.name: c.parameter.neutral for c in mine.coordinates if c not in other.coordinates}
    able = all(
        further[name] in (None, value) if name in further else other.held.get(name) == value
        for name, value in mine.held.items()
    )
    return alike and able and set(other.effects) < set(mine.effects)


def no_worse(fit: Solution, smaller: Solution, budget: int = POLISH_BUDGET) -> Solution:
    """``fit``, or, where a model that it contains fits better, a fit from that one's parameters.

    The further effects start at neutral, where the cost is that of ``smaller``. ``notes`` of the
    result then say so. Raises ValueError where ``fit`` does not contain ``smaller``.
    """
    if not contains(fit, smaller):
        raise ValueError("the smaller model must have fewer of the same effects and the same data")
    if fit.outcome.cost <= smaller.outcome.cost:
        return fit
    again = polish(fit.problem, [neutral_start(fit.problem, smaller.as_base)], budget)
    best = min(again, fit, key=lambda one: one.outcome.cost)
    clear = fit.outcome.cost > _ROUNDING * smaller.outcome.cost
    return replace(best, notes=(*fit.notes, _note(fit, smaller)) if clear else fit.notes)


def _note(fit: Solution, smaller: Solution) -> str:
    named = ", ".join(smaller.problem.effects) or "no effect"
    return (
        f"a first fit ended with {fit.rmse_deg:.4g} deg, worse than the {smaller.rmse_deg:.4g} deg "
        f"of the model with {named}, which it contains; it was repeated from there"
    )
