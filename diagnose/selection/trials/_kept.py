"""What a selection keeps, so that a way which comes by the same model again costs nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from servosight.diagnose.selection.trials._trial import Key, Trial
from servosight.identify.fit import Solution, contains, no_worse

SAME_COST = 1e-6
"""Costs of one model that differ by no more than this share are those of one minimum."""

Way = tuple[str, Key, float, str]
"""How a fit was made, from which model at which cost, with which effect."""


def best_kept(trials: dict[Key, Trial], trial: Trial) -> Trial:
    """``trial``, kept where it is the best of its model; the best one if it ends where that did.

    A fit that came to its end takes the place of one that did not.
    """
    known = trials.get(trial.key)
    if known is not None and not (known.fit.out_of_budget and not trial.fit.out_of_budget):
        margin = SAME_COST * known.fit.outcome.cost
        if abs(trial.fit.outcome.cost - known.fit.outcome.cost) <= margin:
            return known
    if known is None or trial.fit.outcome.cost <= known.fit.outcome.cost:
        trials[trial.key] = trial
    return trial


def fitted_again(trials: dict[Key, Trial], fit: Solution, budget: int) -> Solution:
    """``fit``, or one from the best of those kept that it contains, where that fits better."""
    smaller = [one.fit for one in trials.values() if contains(fit, one.fit)]
    if fit.out_of_budget or not smaller:
        return fit
    return no_worse(fit, min(smaller, key=lambda one: one.outcome.cost), budget)


def reached_deg(trials: Mapping[Key, Trial], effects: Sequence[str]) -> float:
    """The least error of those kept that have fewer effects [deg]; infinite without any.

    Of a model it is the larger of the errors on fitted and on validation data. One with an effect
    at a bound is no answer, and does not count.
    """
    fewer = (one.score for one in trials.values() if len(one.effects) < len(effects))
    both = (one.larger_rmse_deg for one in fewer if not one.at_bounds)
    return min(both, default=math.inf)


def fitted_once(
    fits: dict[Way, Solution], way: str, base: Trial, name: str, fit: Callable[[], Solution]
) -> Solution:
    """What ``fit`` finds one ``way`` from a base, or found there before."""
    key = (way, base.key, base.fit.outcome.cost, name)
    if key not in fits:
        fits[key] = fit()
    return fits[key]
