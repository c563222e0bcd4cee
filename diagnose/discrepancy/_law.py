"""A sparse law for what no catalogued effect accounts for, confirmed by simulation.

Terms are chosen by what they promise to first order (_matching_pursuit.py). Those that promise most
are then fitted with everything else by simulation, and a term stays if it shows on validation data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.diagnose.discrepancy._matching_pursuit import TERMS, TermCandidate, promising
from servosight.diagnose.residuals import held_out_rms
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Trial
from servosight.identify.fit import Solution, polish
from servosight.identify.problem import Problem
from servosight.identify.search import half_squares
from servosight.models.core import Array

MOST_TERMS = 3
FINISHED = 2
"""Of the sketches of what promises most, the best are fitted to the end."""
SKETCH_BUDGET = 120
FINISH_BUDGET = 500
MOST_COST = 20_000.0
"""After simulations of this cost (``Work``) on one model no further term is tried."""
MIN_GAIN = 0.1
"""A term must lower the validation rmse by this share."""
MIN_CLOSED = 0.5
"""The whole law must close this share of the gap between validation rmse and floor."""
MIN_TESTED = 0.25
"""A law that closes less of the gap on the test data, which it has not seen, does not hold."""


@dataclass(frozen=True)
class Found:
    """Terms that close most of the gap between a model's validation error and the floor.

    ``before`` is the best model without them, ``base`` what they were added to (that or a plainer
    one), ``after`` the model with them. ``models`` fitted the first, ``extended`` the last.
    """

    models: ModelSelection
    extended: ModelSelection
    before: Trial
    base: Trial
    after: Trial

    @cached_property
    def test_rms_deg(self) -> tuple[float, float]:
        """Errors on the test data [deg], without and with the law."""
        before, after = self.models.tested(self.before), self.extended.tested(self.after)
        return held_out_rms(before), held_out_rms(after)

    def holds(self, floor_deg: float) -> bool:
        """True where it lowers the error on the test data as well."""
        return share_closed(*self.test_rms_deg, floor_deg) >= MIN_TESTED


def find_law(
    models: ModelSelection,
    bases: Sequence[Trial],
    criterion: AcceptanceCriterion,
    noise_deg: float,
) -> Found | None:
    """The best law on top of one of some models; None where none closes half of the gap.

    ``bases`` are fitted models of ``models``, the plainest first and the best last; what the
    later ones leave is looked at only where a law on the earlier ones does not reach the floor.
    """
    found: list[tuple[ModelSelection, Trial, Trial]] = []
    for base in bases:
        found.append(_extended(models, base, criterion, noise_deg))
        if criterion.explained(found[-1][2].score):
            break
    extended, base, after = max(found, key=lambda one: criterion.value(one[2].score))
    law = Found(models, extended, bases[-1], base, after)
    before_deg, after_deg = (t.score.validation_rmse_deg for t in (bases[-1], after))
    closed = share_closed(before_deg, after_deg, criterion.floor_deg)
    return law if after.effects != base.effects and closed >= MIN_CLOSED else None


def share_closed(before_deg: float, after_deg: float, floor_deg: float) -> float:
    """Share of the gap between an error and the floor that is gone.

    >>> share_closed(0.5, 0.1, 0.1)
    1.0
    """
    return (before_deg - after_deg) / max(before_deg - floor_deg, 1e-12)


def _extended(
    models: ModelSelection, base: Trial, criterion: AcceptanceCriterion, noise_deg: float
) -> tuple[ModelSelection, Trial, Trial]:
    """Terms added to one model, one after the other, as long as they earn their place."""
    own = models.catalogue if base.effects else {}
    terms = {name: term for name, term in TERMS.items() if name not in own}
    extended = models.with_catalogue({**own, **{name: term.effect for name, term in terms.items()}})
    trial = base
    most = models.work.cost + MOST_COST
    for _ in range(MOST_TERMS):
        if models.work.cost >= most or criterion.explained(trial.score):
            break
        ranked = promising(trial, terms, len(models.recordings), noise_deg)
        better = _best(extended, trial, ranked, criterion, most)
        if better is None or not _earns(better, trial, criterion, len(terms)):
            break
        trial = _without(extended, better, base, criterion)
    return extended, base, trial


def _earns(trial: Trial, base: Trial, criterion: AcceptanceCriterion, tried: int) -> bool:
    after, before = trial.score.validation_rmse_deg, base.score.validation_rmse_deg
    gain = criterion.evidence(trial.score, base.score)
    needed = criterion.policy.min_evidence + float(np.log(tried))
    return after <= (1.0 - MIN_GAIN) * before and gain >= needed


def _without(
    extended: ModelSelection, trial: Trial, base: Trial, criterion: AcceptanceCriterion
) -> Trial:
    """The model without the terms that a later one has made needless."""
    for name in trial.effects:
        if name in base.effects or len(trial.effects) - len(base.effects) < 2:
            continue
        smaller = extended.reduced(trial, name)
        if not _earns(trial, smaller, criterion, 1):
            return _without(extended, smaller, base, criterion)
    return trial


def _best(
    extended: ModelSelection,
    base: Trial,
    candidates: Sequence[TermCandidate],
    criterion: AcceptanceCriterion,
    most: float,
) -> Trial | None:
    """The best of ``base`` with one term more, everything fitted anew.

    Once the work has cost ``most`` what promises less is left untried.
    """
    sketches: list[Solution] = []
    for candidate in candidates:
        if sketches and extended.work.cost >= most:
            break
        problem = extended.problem((*base.effects, candidate.name), base.fit.problem.held)
        point = base.fit.outcome.point
        starts = np.array(
            [_start(problem, base, candidate, x) for x in (point, point + candidate.shift)]
        )
        better = int(np.argmin(half_squares(problem.residuals(starts))))
        sketches.append(polish(problem, [starts[better]], SKETCH_BUDGET))
    sketches.sort(key=lambda fit: fit.outcome.cost)
    fits = [polish(f.problem, [f.outcome.point], FINISH_BUDGET) for f in sketches[:FINISHED]]
    trials = [extended.judge(fit) for fit in fits]
    return max(trials, key=lambda trial: criterion.value(trial.score), default=None)


def _start(problem: Problem, base: Trial, candidate: TermCandidate, point: Array) -> Array:
    """A point of the base's problem, with the term's parameters as matching pursuit found them."""
    old = zip(base.fit.problem.coordinates, point, strict=True)
    known = {(c.name, c.recording): float(x) for c, x in old}
    for parameter, value in zip(
        TERMS[candidate.name].effect.parameters, candidate.start, strict=True
    ):
        known[(f"{candidate.name}.{parameter.name}", None)] = value
    low, high = problem.bounds
    return np.clip([known[(c.name, c.recording)] for c in problem.coordinates], low, high)
