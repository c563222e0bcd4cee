"""From recordings to the missing effect: the diagnosis that the user reads."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from servosight.diagnose.discrepancy import Law, reported_law
from servosight.diagnose.evidence import Evidence, gather
from servosight.diagnose.outcome import (
    DiagnosisData,
    Outcome,
    Rivalry,
    accepted,
    diagnosis_data,
    rivalry,
    select,
    verdict_of,
    with_ladder,
)
from servosight.diagnose.residuals import findings, worst_windows
from servosight.diagnose.result import Diagnosis, LadderStep, Verdict, recording_uses
from servosight.diagnose.result.caveats import (
    assumed,
    compensating,
    doubts,
    ended,
    unmoved,
)
from servosight.diagnose.result.next_step import next_experiment
from servosight.diagnose.result.wording import headline_and_summary
from servosight.diagnose.selection import (
    MOST_ROWS,
    PriorKnowledge,
    SelectionPolicy,
)
from servosight.identify.fit import early_notes, exchanged_notes
from servosight.identify.foreign import is_around_fmu
from servosight.identify.problem import measured_by_servo, unused_disturbances
from servosight.identify.transmission import transmissions
from servosight.models.core import Recording, StageProgress, Table, one_or_more, silent
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in
from servosight.models.excitation import CommandLimits


def diagnose(
    recordings: Sequence[Recording],
    validate: Sequence[Recording] = (),
    test: Sequence[Recording] = (),
    *,
    catalogue: Mapping[str, Effect] | None = None,
    auto: bool = False,
    tolerance: float | None = None,
    limits: CommandLimits | None = None,
    policy: SelectionPolicy | None = None,
    most_rows: int = MOST_ROWS,
    prior: PriorKnowledge | None = None,
    progress: StageProgress = silent,
) -> Diagnosis:
    """Compare the linear model with recordings, rank what could be missing; add with ``auto``.

    Parameters are fitted to ``recordings``, effects are chosen by ``validate`` and errors reported
    on ``test``. Without the latter two, of every six blocks of one second four are fitted, one
    validates and one tests; with ``validate`` alone, its blocks alternate between validation and
    test. ``catalogue`` holds the effects to choose from (default: the built-in ones).
    ``tolerance`` [deg] is what no model need be right within (default 0.05 % of the moved range).
    ``limits`` bound the next experiment (default: what the recordings' commands have used).
    Recordings with more than ``most_rows`` rows of command and samples together are diagnosed on
    stretches of the long ones; a warning says so. ``prior`` is what is known before: the first step
    is then a model with those effects. InputError where there is no recording to fit, or for a
    tolerance that is none.
    """
    began = time.perf_counter()
    known = built_in() if catalogue is None else catalogue
    prior = prior or PriorKnowledge()
    groups = one_or_more(recordings), validate, test
    data = diagnosis_data(groups, known, prior, tolerance=tolerance, most_rows=most_rows)
    criterion = data.criterion(policy or SelectionPolicy())
    searched = select(data, criterion, prior, auto=auto, progress=progress)
    outcome, ladder = with_ladder(searched)
    verdict = verdict_of(outcome)
    rivals = rivalry(outcome, data, limits)
    law = _law(outcome, data, progress)
    found = _result(data, outcome, ladder, verdict, rivals, law)
    return replace(found, seconds=time.perf_counter() - began)


def _law(outcome: Outcome, data: DiagnosisData, progress: StageProgress) -> Law | None:
    """A law of what the effects leave, where something is left and effects were added.

    A law is a torque within the position loop, which an FMU does not show.
    """
    done = outcome.criterion.explained(outcome.last.score)
    if not outcome.auto or done or is_around_fmu(data.catalogue):
        return None
    progress("searching for a law of the remaining error", 0, 1)
    return reported_law(
        outcome.models, outcome.linear, outcome.last, outcome.criterion, data.levels.noise_deg
    )


def _result(
    data: DiagnosisData,
    outcome: Outcome,
    ladder: Table[LadderStep],
    verdict: Verdict,
    rivals: Rivalry,
    law: Law | None,
) -> Diagnosis:
    """Every field of the result but the time that it took, with the error of the first model and
    of the last tested, and both put into words."""
    levels, models, stable = data.levels, outcome.models, outcome.stability
    judged, judged_last = models.tested(outcome.linear), models.tested(outcome.last)
    left = findings(judged_last, levels.floor_deg, levels.noise_deg)
    evidence = gather(
        models, outcome.linear, outcome.last, judged_last, left, outcome.criterion,
        outcome.selected.cut_short,
    )  # fmt: skip
    next_ = _next(data, outcome, verdict, rivals, evidence)
    headline, summary = headline_and_summary(
        verdict,
        ladder,
        rivals.candidates,
        law,
        levels,
        evidence,
        stable,
        models.known.without_effects,
    )
    return Diagnosis(
        noise_deg=levels.noise_deg,
        scatter_deg=data.scatter.rms_deg if data.scatter else None,
        tolerance_deg=levels.tolerance_deg,
        floor_deg=levels.floor_deg,
        verdict=verdict,
        headline=headline,
        summary=summary,
        effects=outcome.effects,
        ladder=ladder,
        candidates=rivals.candidates,
        where=Table(worst_windows(judged)),
        findings=Table(findings(judged, levels.floor_deg, levels.noise_deg)),
        remaining=Table(left if outcome.grown else ()),
        alternatives=tuple(rival.effects for rival in rivals.rivals[1:]),
        next_experiment=next_,
        proposal=rivals.proposal,
        law=law,
        recordings=recording_uses(models.split, data.spans),
        warnings=_warnings(data, outcome, verdict, ladder[-1], evidence),
        seconds=0.0,
        regimes=Table(evidence.regimes),
        known=models.known,
        stability=stable.shares,
        resamples=stable.resamples,
        repeated=evidence.repeated,
        unexplained=evidence.unexplained and replace(evidence.unexplained, next_step=next_),
        detectable=Table(evidence.detectable),
        equivalents=stable.equivalents,
        one_of=stable.one_of,
        transmissions=transmissions([*models.split.recordings, *models.split.carried]),
    )


def _next(
    data: DiagnosisData, outcome: Outcome, verdict: Verdict, rivals: Rivalry, evidence: Evidence
) -> str:
    """One sentence on what to do next; the best candidate is named where it is accepted."""
    return next_experiment(
        verdict,
        rivals.proposal,
        accepted(outcome),
        outcome.auto,
        evidence.leading,
        evidence.unexplained,
        card=not is_around_fmu(data.catalogue),
    )


def _warnings(
    data: DiagnosisData, outcome: Outcome, verdict: Verdict, last: LadderStep, evidence: Evidence
) -> tuple[str, ...]:
    """On what was left out, held, assumed and not reached."""
    models = outcome.models
    error_deg = max(outcome.last.score.mean_square_deg2**0.5, last.held_out_rmse_deg)
    slight = error_deg <= outcome.criterion.policy.far * data.levels.floor_deg
    return (
        *data.left_out,
        *unused_disturbances(data.whole, outcome.last.effects, data.catalogue),
        *data.shortened,
        *models.split.warnings,
        *outcome.timing,
        *exchanged_notes(data.whole),
        *(
            ()
            if is_around_fmu(data.catalogue)
            else early_notes(outcome.last.fit, data.levels.floor_deg)
        ),
        *assumed(outcome.last.fit.problem.held, models.held),
        *measured_by_servo(data.whole, models.known.fixed),
        *compensating(verdict, last.effects, evidence, slight),
        *unmoved(last),
        *doubts(verdict, last, data.levels),
        *ended(verdict, evidence.cut_short, outcome.simulations),
    )
