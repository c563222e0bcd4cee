"""Other models that err no more than the chosen one, as far as the scatter of the errors tells.

Above the floor no model is right, and it is not noise that decides between two of them but where
the misfit of each happens to fall. Another run of the same servo then decides otherwise. Whether
two models differ by more is seen from their squared errors, block by block: the mean difference
against its scatter (Vuong, Econometrica 57 (1989) 307; a set of models that no such comparison
tells apart: Hansen, Lunde and Nason, Econometrica 79 (2011) 453).
"""

from __future__ import annotations

import numpy as np

from servosight.diagnose.residuals import TEST, Judged
from servosight.diagnose.selection import BLOCK_S, AcceptanceCriterion, ModelSelection, Trial
from servosight.models.core import Array

SIGMAS = 2.0
"""Two models differ where their mean difference is this many times its standard error."""
FEWEST_BLOCKS = 4
"""Fewer blocks have no scatter to compare with: then no models are said to be alike."""
MOST = 4
"""So many are reported, the cheapest."""


def equivalents(
    models: ModelSelection, last: Trial, criterion: AcceptanceCriterion
) -> tuple[tuple[str, ...], ...]:
    """Sets of effects that the data do not tell from those of ``last``, the cheapest first.

    Their price, with the error on all fitted and validation samples, is at most that of one effect
    above the price of ``last``: few seconds of validation decide by chance. None where ``last``
    explains the data: then the noise decides. A set that has all of ``last`` and more, or effects
    that contain them, is no other answer, unless it does without another k.
    """
    if not last.effects or criterion.explained(last.score):
        return ()
    most = criterion.overall_price(last.score) + criterion.policy.effect_price
    near: dict[tuple[str, ...], float] = {}
    for trial in models.trials.values():
        price = criterion.overall_price(trial.score)
        special = {simple for own in trial.effects for simple in models.catalogue[own].contains}
        more = {*trial.effects, *special} >= set(last.effects)
        other = trial.effects and not (more and trial.held == last.held)
        if not other or price > most or not models.known.allows(trial.effects):
            continue
        if trial.effects != last.effects and not _differ(last, trial):
            near[trial.effects] = min(price, near.get(trial.effects, np.inf))
    least = [one for one in near if not any(set(other) < set(one) for other in near)]
    return tuple(sorted(least, key=lambda effects: near[effects])[:MOST])


def _differ(first: Trial, second: Trial) -> bool:
    """True where one model's squared error is less, beyond its scatter from block to block."""
    pairs = zip(first.judged, second.judged, strict=True)
    change = np.concatenate([_blocks(one) - _blocks(other) for one, other in pairs])
    change = change[np.isfinite(change)]
    if change.size < FEWEST_BLOCKS:
        return True
    return bool(abs(change.mean()) > SIGMAS * change.std(ddof=1) / np.sqrt(change.size))


def _blocks(judged: Judged) -> Array:
    """Sum of squared errors of each block of one second [deg^2], NaN where it is for the test."""
    time_s = judged.recording.time_s
    number = np.floor((time_s - time_s[0]) / BLOCK_S).astype(np.int64)
    seen = judged.uses != TEST
    squares = np.bincount(number, np.where(seen, judged.error_deg, 0.0) ** 2)
    return np.where(np.bincount(number, seen) > 0.0, squares, np.nan)
