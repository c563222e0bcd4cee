"""From recordings to the missing effect: the diagnosis that the user reads."""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from servosight.diagnose._ladder import ladder_steps
from servosight.diagnose.discrepancy import reported_law
from servosight.diagnose.evidence import (
    Evidence,
    Stability,
    firm,
    gather,
    run_floor,
    undetermined,
)
from servosight.diagnose.experiment import Proposal, propose
from servosight.diagnose.residuals import (
    findings,
    held_out_rms,
    held_out_samples_of,
    worst_windows,
)
from servosight.diagnose.result import Candidate, Diagnosis, Verdict, recording_uses
from servosight.diagnose.result.caveats import (
    assumed,
    compensating,
    doubts,
    ended,
    measured_by_servo,
)
from servosight.diagnose.result.wording import Levels, headline_and_summary, next_experiment
from servosight.diagnose.selection import (
    MOST_ROWS,
    REMEDY,
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    Resolution,
    Selected,
    SelectionPolicy,
    Split,
    StepwiseSelector,
    Trial,
    alternatives,
    confounded,
    cut,
    own_latencies,
    stretches,
)
from servosight.identify.fit import floor_deg, tolerance_deg
from servosight.identify.foreign import is_around_fmu
from servosight.identify.problem import (
    joint_noise_deg,
    offered,
    thinned,
    unused_disturbances,
    usable_views,
)
from servosight.models.core import Recording, StageProgress, Table, one_or_more, silent
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in
from servosight.models.excitation import CommandLimits


# Long by its keywords and by the fields of its result: each is a line.
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
    # Longer than others because it fills every field of the result, and does nothing else.
    began = time.perf_counter()
    if catalogue is None:
        catalogue = built_in()
    given = one_or_more(recordings), validate, test
    usable, left_out = zip(*map(usable_views, given), strict=True)
    recordings, validate, test = usable
    prior = prior or PriorKnowledge()
    catalogue = offered(catalogue, recordings, prior.first)
    every = (*recordings, *validate, *test)
    noise = joint_noise_deg(every)
    tolerance = tolerance_deg(every, tolerance)
    scatter, repeats = run_floor(every)
    floor = floor_deg(every, max(noise, scatter or 0.0), tolerance)
    criterion = AcceptanceCriterion(floor, tolerance, policy or SelectionPolicy())
    spans, notes = stretches(every, most_rows)
    parts = [cut(recording, own) for recording, own in zip(every, spans, strict=True)]
    scored, thinning = thinned([part for own in parts for part in own])
    fitted = sum(map(len, parts[: len(recordings)]))
    chosen = fitted + sum(map(len, parts[len(recordings) :][: len(validate)]))
    split = scored[:fitted], scored[fitted:chosen], scored[chosen:]
    runs = [run for run, own in enumerate(parts) for _ in own][:chosen]
    models, latencies = _models(*split, catalogue, criterion, prior, runs)
    selector = StepwiseSelector(models, criterion, progress)
    selected, stable = selector.first_step() if not auto else selector.select(), Stability()
    searched = models.work.simulations
    if auto:
        progress("leaving out parts of the data", 0, 1)
        selected, stable = firm(models, criterion, selected)
    linear, last = selected.steps[0].trial, selected.steps[-1].trial
    ladder = ladder_steps(models, criterion, selected.steps)
    open_ = models.known.removable(ladder[-1].effects) if auto else ()
    unknown = undetermined(ladder[-1].parameters, open_, catalogue, ladder[-1].correlation)
    stable = replace(stable, undetermined=unknown)
    verdict = _verdict(models, criterion, last)
    effects = tuple(one for one in _in_order(models, selected) if one not in stable.uncertain)
    resolution = Resolution(noise, criterion)
    candidates = _candidates(models, selected, resolution)
    rivals = _rivals(models, selected, resolution, auto)
    proposal = propose(rivals, models, noise, tolerance, limits) if len(rivals) > 1 else None
    law = None
    # A law is a torque within the position loop, which an FMU does not show.
    if auto and not criterion.explained(last.score) and not is_around_fmu(catalogue):
        progress("searching for a law of the remaining error", 0, 1)
        law = reported_law(models, linear, last, criterion, noise)
    levels = Levels(
        noise_deg=noise, tolerance_deg=tolerance, floor_deg=floor, scatter_deg=scatter or 0.0
    )
    judged, judged_last = models.tested(linear), models.tested(last)
    left = findings(judged_last, floor, noise)
    known = gather(models, linear, last, judged_last, left, criterion)
    untried = models.known.without_effects
    headline, summary = headline_and_summary(
        verdict, ladder, candidates, law, levels, known, stable, untried
    )
    return Diagnosis(
        noise_deg=noise,
        scatter_deg=scatter,
        tolerance_deg=tolerance,
        floor_deg=floor,
        verdict=verdict,
        headline=headline,
        summary=summary,
        effects=effects,
        ladder=ladder,
        candidates=candidates,
        where=Table(worst_windows(judged)),
        findings=Table(findings(judged, floor, noise)),
        remaining=Table(left if _grown(selected) else ()),
        alternatives=tuple(rival.effects for rival in rivals[1:]),
        next_experiment=_next(
            verdict,
            proposal,
            selected,
            candidates,
            criterion,
            auto,
            known,
            card=not is_around_fmu(catalogue),
        ),
        proposal=proposal,
        law=law,
        recordings=recording_uses(models.split, spans),
        warnings=(
            *itertools.chain(*left_out, repeats),
            *unused_disturbances(every, last.effects, catalogue),
            *notes,
            *thinning,
            *models.split.warnings,
            *latencies,
            *assumed(last.fit.problem.held, models.held),
            *measured_by_servo(every, models.known.fixed),
            *compensating(verdict, effects, known),
            *doubts(verdict, ladder[-1], levels),
            *ended(selected.cut_short, searched),
        ),
        seconds=time.perf_counter() - began,
        regimes=Table(known.regimes),
        known=models.known,
        stability=stable.shares,
        resamples=stable.resamples,
        repeated=known.repeated,
        unexplained=known.unexplained,
        detectable=Table(known.detectable),
        equivalents=known.equivalents,
    )


def _models(
    recordings: Sequence[Recording],
    validate: Sequence[Recording],
    test: Sequence[Recording],
    catalogue: Mapping[str, Effect],
    criterion: AcceptanceCriterion,
    known: PriorKnowledge,
    runs: Sequence[int],
) -> tuple[ModelSelection, tuple[str, ...]]:
    """The models of recordings with one latency, and sentences on those that had another.

    Where what is missing shows in the validation samples alone, another third is held out: no
    effect can be fitted to what the fit does not see. ``runs`` numbers the runs of the recordings
    that fit and validate.
    """
    models = ModelSelection(Split.of(recordings, validate, test), catalogue, known)
    late_s = (0.0,) * len(runs)
    notes: tuple[str, ...] = ()
    found = own_latencies(models, runs)
    if found is not None:
        late_s = tuple(found.late_s.tolist())
        notes = found.sentences([one.name for one in (*recordings, *validate)], REMEDY)
        models = models.with_split(models.split.earlier(late_s))
    score = models.first().score
    if criterion.settled(score) and not criterion.explained(score) and not validate:
        anew = Split.of(recordings, validate, test, choice=1).earlier(late_s)
        models = models.with_split(anew)
    return models, notes


def _verdict(models: ModelSelection, criterion: AcceptanceCriterion, last: Trial) -> Verdict:
    """The last model must be at the floor on the test data, and on what chose it.

    As in the selection, validation data may be fitted, too, before a model is said to fail there.
    """
    judged = models.tested(last)
    tested = criterion.at_floor(held_out_rms(judged), held_out_samples_of(judged))
    if not tested or not (
        criterion.explained(last.score) or models.explained_whole(last, criterion)
    ):
        return Verdict.UNEXPLAINED
    return Verdict.EXPLAINED if last.effects else Verdict.NO_EFFECT_MISSING


def _in_order(models: ModelSelection, selected: Selected) -> tuple[str, ...]:
    """The final effects in the order in which they were added, those known before first."""
    final = selected.steps[-1].trial.effects
    added = [step.added for step in selected.steps if step.added is not None]
    first = models.known.first
    return tuple(name for name in dict.fromkeys((*first, *added)) if name in final)


def _candidates(
    models: ModelSelection, selected: Selected, resolution: Resolution
) -> Table[Candidate]:
    linear = selected.steps[0].trial
    groups = confounded(selected.singles, linear, resolution, models.whole)
    found = []
    for trial in selected.singles:
        (name,) = set(trial.effects) - set(linear.effects)
        found.append(
            Candidate(
                effect=name,
                validation_rmse_deg=trial.score.validation_rmse_deg,
                held_out_rmse_deg=held_out_rms(models.tested(trial)),
                evidence=resolution.criterion.evidence(trial.score, linear.score),
                confounded_with=groups[name],
            )
        )
    return Table(sorted(found, key=lambda one: -one.evidence))


def _rivals(
    models: ModelSelection, selected: Selected, resolution: Resolution, auto: bool
) -> tuple[Trial, ...]:
    """The model that was chosen, or would be next, and those that predict the same.

    None where the linear model is all that is left.
    """
    criterion = resolution.criterion
    linear, chosen = selected.steps[0].trial, selected.steps[-1].trial
    if not auto and selected.singles and not criterion.done(linear.score):
        chosen = selected.singles[0]
    evidence = criterion.evidence(chosen.score, linear.score)
    if chosen.effects == linear.effects or evidence <= criterion.policy.min_evidence:
        return ()
    tried = [one for one in models.alike(chosen) if models.known.allows(one.effects)]
    return (chosen, *alternatives(chosen, tried, resolution, models.whole))


def _grown(selected: Selected) -> bool:
    """True where the last model has other effects than the first."""
    return selected.steps[-1].trial.effects != selected.steps[0].trial.effects


def _next(
    verdict: Verdict,
    proposal: Proposal | None,
    selected: Selected,
    candidates: Sequence[Candidate],
    criterion: AcceptanceCriterion,
    auto: bool,
    known: Evidence,
    card: bool,
) -> str:
    """One sentence on what to do next; the best candidate is named where it is accepted."""
    first, candidate = selected.steps[0].trial, None
    for best in selected.singles[:1]:
        if criterion.earns(best.score, first.score, len(candidates)):
            (candidate,) = set(best.effects) - set(first.effects)
    return next_experiment(
        verdict, proposal, candidate, auto, known.leading, known.unexplained, card
    )
