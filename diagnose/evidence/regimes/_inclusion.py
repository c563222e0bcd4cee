"""What fitting a recording too gives, tried: the same effects, fitted to half of it as well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals import rms
from servosight.diagnose.selection import BLOCK_S, ModelSelection, Trial, own_point, predict_fixed
from servosight.identify.fit import polish
from servosight.identify.problem import Problem
from servosight.models.core import Recording, degrees

BUDGET = 400
"""Simulations that the trial may cost."""
FALLS = 0.5
"""An error that falls to this share of what it was is due to the regime."""
ALIKE = 0.9
"""Errors of this ratio or nearer to each other are alike."""


@dataclass(frozen=True, kw_only=True)
class Inclusion:
    """The error on every second block of a recording, with the others fitted and without them.

    ``before_deg`` with the parameters of the fitted data, ``after_deg`` with parameters that were
    fitted to the other blocks as well: rms on the same samples. It decides nothing.
    """

    before_deg: float
    after_deg: float
    sentence: str


def include(models: ModelSelection, trial: Trial, recording: Recording) -> Inclusion | None:
    """Fit the effects of ``trial`` to half of ``recording``, too; None where it has no two halves.

    Blocks of one second alternate; bias and initial state of the recording are found on the half
    that is fitted in both cases.
    """
    since = recording.time_s - recording.time_s[0]
    half = np.floor(since / BLOCK_S).astype(np.int64) % 2 == 0
    if half.all():
        return None
    fit = trial.fit
    physical = fit.outcome.point[: fit.problem.physical]
    alone = Problem.of([recording], models.catalogue, trial.effects, [half])
    before = recording.angle_deg - predict_fixed(recording, alone, physical)
    problem = Problem.of(
        (*models.recordings, recording),
        models.catalogue,
        trial.effects,
        (*models.split.masks, half),
        fit.problem.ranges,
        fit.problem.held,
    )
    own = own_point(recording, alone, physical)[fit.problem.physical :]
    together = polish(problem, [np.concatenate([fit.outcome.point, own])], BUDGET)
    after = recording.angle_deg - together.problem.predict(together.outcome.point)[-1][0]
    first, last = rms([before[~half]]), rms([after[~half]])
    return Inclusion(
        before_deg=first, after_deg=last, sentence=inclusion_words(recording.name, first, last)
    )


def inclusion_words(name: str, first: float, last: float) -> str:
    """What an error [deg] on the other half of a recording, before and after, means."""
    tried = f"Tried: with half of {name} fitted too, the error of the same model on the other half"
    changed = f"from {degrees(first)} to {degrees(last)} rms"
    if last <= FALLS * first:
        return f"{tried} falls {changed}."
    if last <= ALIKE * first:
        return f"{tried} falls {changed} only."
    risen = last > first / ALIKE
    how = (
        f"rises {changed}" if risen else f"stays at {degrees(last)} rms (before: {degrees(first)})"
    )
    return f"{tried} {how}: other parameters are not enough, an effect is missing."
