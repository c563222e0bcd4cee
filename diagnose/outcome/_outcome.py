"""The selection of effects for a diagnosis, and what follows from it before a word is written."""

from __future__ import annotations

from dataclasses import dataclass, replace

from servosight.diagnose.evidence import (
    Stability,
    contained,
    equivalents,
    firm,
    interchangeable,
    motionless,
    not_shown_beyond,
    special_case,
    stability,
    undetermined,
    unmeasured,
)
from servosight.diagnose.outcome._data import DiagnosisData
from servosight.diagnose.outcome._ladder import ladder_steps
from servosight.diagnose.residuals import held_out_rms, held_out_samples_of
from servosight.diagnose.result import LadderStep, Verdict
from servosight.diagnose.selection import (
    FRAMES_REMEDY,
    REMEDY,
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    Selected,
    Split,
    StepwiseSelector,
    Trial,
    command_frames,
    latencies_left,
    own_latencies,
)
from servosight.identify.fit import FRAMES_GAIN, POSSIBLE_FRAMES_GAIN, CommandFrames, FramedFit
from servosight.models.core import StageProgress, Table

_LIMITED_DRIVES = (("torque_saturation",), ("speed_limit",), ("current_limit",))


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """A selection that has ended: its steps, the last of which is the model that is named.

    ``auto`` is True where effects were added, False where only single candidates were ranked;
    ``simulations`` is what the search took, without the check of its stability; ``timing`` are
    sentences on recordings whose angles lag those of others, taken out or not, and on those whose
    commands act once a frame.
    """

    models: ModelSelection
    criterion: AcceptanceCriterion
    selected: Selected
    stability: Stability
    auto: bool
    simulations: int
    timing: tuple[str, ...]

    @property
    def linear(self) -> Trial:
        """The first step's model: the linear one, with the effects that are known before."""
        return self.selected.steps[0].trial

    @property
    def last(self) -> Trial:
        """The last step's model."""
        return self.selected.steps[-1].trial

    @property
    def grown(self) -> bool:
        """True where the last model has other effects than the first."""
        return self.last.effects != self.linear.effects

    @property
    def effects(self) -> tuple[str, ...]:
        """What is named: the last model's effects that are certain, or what is certain of them, in
        the order of their steps, those known before first."""
        added = [step.added for step in self.selected.steps if step.added is not None]
        order = dict.fromkeys((*self.models.known.first, *added))
        return self.stability.named([name for name in order if name in self.last.effects])


def select(
    data: DiagnosisData,
    criterion: AcceptanceCriterion,
    prior: PriorKnowledge,
    *,
    auto: bool,
    progress: StageProgress,
    framed: FramedFit | None = None,
) -> Outcome:
    """Rank single candidates; with ``auto`` add effects and check which names are stable.

    ``framed``: how the commands of the recordings act once a frame, where that is known already.
    It shows beside the first model, or, where much else is missing, beside the last one alone: all
    is then done again, and that counts where its last model is at the floor or errs clearly less.
    """
    models, timing, framed = _models(data, criterion, prior, framed, progress)
    selector = StepwiseSelector(models, criterion, progress)
    selected, stable = selector.select() if auto else selector.first_step(), Stability()
    searched = models.work.simulations
    if auto:
        progress("leaving out parts of the data", 0, 1)
        selected, stable = firm(models, criterion, selected)
        checked = last = selected.steps[-1].trial
        while step := special_case(models, last, criterion):
            selected, last = replace(selected, steps=(*selected.steps, step)), step.trial
        if last is not checked:
            stable = stability(models, criterion, last)
        if framed is None and not criterion.explained(last.score):
            framed = _possible_frames(models, last, data)
            if framed is not None:
                other = select(data, criterion, prior, auto=auto, progress=progress, framed=framed)
                most_deg = (1.0 - FRAMES_GAIN) * last.score.larger_rmse_deg
                score = other.last.score
                if criterion.done(score) or score.larger_rmse_deg < most_deg:
                    return other
        if not any(models.split.late_s) and not criterion.explained(last.score):
            timing = (*timing, *latencies_left(models, last, _names(data)))
    return Outcome(
        models=models,
        criterion=criterion,
        selected=selected,
        stability=stable,
        auto=auto,
        simulations=searched,
        timing=timing,
    )


def _possible_frames(models: ModelSelection, last: Trial, data: DiagnosisData) -> FramedFit | None:
    """The frames beside the last model or, if that leaves less, beside the best limit of the drive.

    Servos that are driven by pulses have one, and frames may be why it was not taken: beside a
    model without it their times are found wrong.
    """
    limited = [one for one in models.trials.values() if one.effects in _LIMITED_DRIVES]
    tried = [last, *sorted(limited, key=lambda one: one.score.train_rmse_deg)[:1]]
    found = [
        command_frames(models, one, data.runs, data.levels.floor_deg, POSSIBLE_FRAMES_GAIN)
        for one in tried
    ]
    return min((one for one in found if one), key=lambda one: one.rmse_deg, default=None)


def with_ladder(outcome: Outcome) -> tuple[Outcome, Table[LadderStep]]:
    """The steps as they are shown, and the outcome that knows which names are open: by the sigmas
    of their parameters or of T, and by other models that do as well."""
    ladder = ladder_steps(outcome.models, outcome.criterion, outcome.selected.steps)
    last = ladder[-1]
    open_ = outcome.models.known.removable(last.effects) if outcome.auto else ()
    unknown = undetermined(last.parameters, open_, outcome.models.catalogue, last.correlation)
    others = equivalents(outcome.models, outcome.last, outcome.criterion) if open_ else ()
    catalogue = outcome.models.catalogue
    stable = replace(
        outcome.stability,
        undetermined=unknown,
        unmeasured=unmeasured(last.parameters, open_, catalogue),
        motionless=motionless(last.parameters, open_, catalogue),
        equivalents=others,
        closer=bool(others) and outcome.criterion.explained(outcome.last.score),
        one_of=interchangeable(last.effects, others, catalogue),
    )
    excluded = outcome.models.known.without_effects
    not_shown = not_shown_beyond(last.parameters, open_, catalogue)
    stable = contained(last.effects, stable, catalogue, excluded, not_shown)
    return replace(outcome, stability=stable), ladder


def verdict_of(outcome: Outcome) -> Verdict:
    """The last model must be at the floor on the test data, and on all validation data.

    As in the selection, validation data may be fitted, too, before a model is said to fail there.
    """
    models, criterion, last = outcome.models, outcome.criterion, outcome.last
    judged = models.tested(last)
    tested = criterion.at_floor(held_out_rms(judged), held_out_samples_of(judged))
    validated = criterion.explained(last.score) and criterion.at_floor(
        last.validation_rmse_deg, last.validation_errors_deg.size
    )
    if not tested or not (validated or models.explained_whole(last, criterion)):
        return Verdict.UNEXPLAINED
    return Verdict.EXPLAINED if last.effects else Verdict.NO_EFFECT_MISSING


def _models(
    data: DiagnosisData,
    criterion: AcceptanceCriterion,
    known: PriorKnowledge,
    framed: FramedFit | None,
    progress: StageProgress,
) -> tuple[ModelSelection, tuple[str, ...], FramedFit | None]:
    """The models of recordings with one latency, and sentences on those that had another, or whose
    commands act once a frame; and how they do.

    Where what is missing shows in the validation samples alone, another third is held out: no
    effect can be fitted to what the fit does not see.
    """
    groups = data.fitted, data.validate, data.test
    models = ModelSelection(Split.of(*groups), data.catalogue, known)
    frames: tuple[CommandFrames | None, ...] = (None,) * len(data.runs)
    late_s = (0.0,) * len(data.runs)
    notes: tuple[str, ...] = ()
    if framed is None:
        framed = command_frames(models, models.first(), data.runs, data.levels.floor_deg)
    if framed is not None:
        frames = framed.frames
        notes = framed.sentences(_names(data), FRAMES_REMEDY)
        models = models.with_split(models.split.in_frames(frames))
    found = own_latencies(
        models, data.runs, lambda: StepwiseSelector(models, criterion, progress).joint()
    )
    if found is not None:
        late_s = tuple(found.late_s.tolist())
        notes = (*notes, *found.sentences(_names(data), REMEDY))
        models = models.with_split(models.split.earlier(late_s))
    score = models.first().score
    if criterion.settled(score) and not criterion.explained(score) and not data.validate:
        split = Split.of(*groups, choice=1)
        models = models.with_split(split.in_frames(frames).earlier(late_s))
    return models, notes, framed


def _names(data: DiagnosisData) -> list[str]:
    """What the recording of each stretch to fit or to validate is called."""
    return [data.whole[run].name for run in data.runs]
