"""Candidates and models that predict the same, and the experiment that tells them apart."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.experiment import Proposal, propose
from servosight.diagnose.outcome._data import DiagnosisData
from servosight.diagnose.outcome._outcome import Outcome
from servosight.diagnose.residuals import held_out_rms
from servosight.diagnose.result import Candidate
from servosight.diagnose.selection import Resolution, Score, Trial, alternatives, confounded, new_in
from servosight.models.core import Table
from servosight.models.excitation import CommandLimits


@dataclass(frozen=True)
class Rivalry:
    """The single ``candidates`` by evidence; the chosen model and its ``rivals``, none where the
    linear model is all that is left; the ``proposal`` that tells these apart, where there are two.
    """

    candidates: Table[Candidate]
    rivals: tuple[Trial, ...]
    proposal: Proposal | None


def rivalry(outcome: Outcome, data: DiagnosisData, limits: CommandLimits | None) -> Rivalry:
    """What the recordings do not distinguish, and the command within ``limits`` that does."""
    noise, tolerance = data.levels.noise_deg, data.levels.tolerance_deg
    resolution = Resolution(noise, outcome.criterion)
    rivals = _rivals(outcome, resolution)
    found = _candidates(outcome, resolution)
    proposal = None
    if len(rivals) > 1:
        proposal = propose(rivals, outcome.models, noise, tolerance, limits)
    return Rivalry(found, rivals, proposal)


def accepted(outcome: Outcome) -> str | None:
    """The best single candidate, where it alone would be accepted."""
    singles, first = outcome.selected.singles, outcome.linear
    if not singles or not outcome.criterion.earns(singles[0].score, first.score, len(singles)):
        return None
    return new_in(singles[0], first)


def _candidates(outcome: Outcome, resolution: Resolution) -> Table[Candidate]:
    """All single candidates; what promised too little to be tried is fitted roughly for them."""
    models, selected, linear = outcome.models, outcome.selected, outcome.linear
    tried = {new_in(trial, linear): trial for trial in selected.singles}
    rest = [name for name in models.candidates(linear) if name not in tried]
    tried |= {name: models.judge(models.sketched(linear, name).fit) for name in rest}
    groups = confounded(list(tried.values()), linear, resolution, models.whole)
    found = []
    for name, trial in tried.items():
        found.append(
            Candidate(
                effect=name,
                validation_rmse_deg=trial.validation_rmse_deg,
                held_out_rmse_deg=held_out_rms(models.tested(trial)),
                evidence=resolution.criterion.evidence(trial.score, linear.score),
                confounded_with=groups[name],
                at_bounds=_driven(trial.score, linear.score),
            )
        )
    return Table(sorted(found, key=lambda one: -one.evidence))


def _driven(score: Score, first: Score) -> tuple[str, ...]:
    """What rests on a bound of its range and did not in the ``first`` model."""
    begun = {*first.core_at_bounds, *first.at_bounds}
    return tuple(name for name in (*score.core_at_bounds, *score.at_bounds) if name not in begun)


def _rivals(outcome: Outcome, resolution: Resolution) -> tuple[Trial, ...]:
    """The model that was chosen, or would be next, and those that predict the same.

    Empty where the linear model is all that is left.
    """
    models, criterion, selected = outcome.models, outcome.criterion, outcome.selected
    linear, chosen = outcome.linear, outcome.last
    if not outcome.auto and selected.singles and not criterion.done(linear.score):
        chosen = selected.singles[0]
    evidence = criterion.evidence(chosen.score, linear.score)
    if chosen.effects == linear.effects or evidence <= criterion.policy.min_evidence:
        return ()
    tried = [one for one in models.alike(chosen) if models.known.allows(one.effects)]
    return (chosen, *alternatives(chosen, tried, resolution, models.whole))
