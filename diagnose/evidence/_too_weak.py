"""A further effect with which the last model is at the floor, and that gains too little for a name.

A model is at the floor from 1.10 floors on, which is 0.46 floors beside the floor itself. An effect
that removes more than that and less than the criterion asks for is not accepted, though with it
nothing is left.
"""

from __future__ import annotations

from servosight.diagnose.residuals import phrased
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Trial, new_in
from servosight.models.core import degrees


def too_weak(models: ModelSelection, last: Trial, criterion: AcceptanceCriterion) -> str | None:
    """A sentence on the effect with the most evidence of those that take ``last`` to the floor.

    Fitted and validation data must be there with it, and it must be learnt and have the evidence of
    an effect that is accepted. None where there is none, or where ``last`` is at the floor.
    """
    if criterion.done(last.score):
        return None
    further = [
        trial
        for trial in models.trials.values()
        if set(trial.effects) > set(last.effects) and len(trial.effects) == len(last.effects) + 1
    ]
    able = [
        trial
        for trial in further
        if criterion.done(trial.score)
        and criterion.is_evident(trial.score, last.score, len(further))
        and not criterion.earns(trial.score, last.score, len(further))
        and models.known.allows(trial.effects)
    ]
    if not able:
        return None
    also = " as well" if last.effects else ""
    best = criterion.ranked(able, lambda trial: trial.score)[0]
    before, after = (one.score.mean_square_deg2 for one in (last, best))
    return (
        f"With {phrased([new_in(best, last)])}{also}, the rms error of the fitted and the "
        f"validation data falls from {degrees(before**0.5)} to {degrees(after**0.5)}, at the "
        f"floor; it takes off {degrees(max(before - after, 0.0) ** 0.5)} rms, too little to be "
        f"named: record more of the motion that shows it, or add it by --with "
        f"{new_in(best, last)}."
    )
