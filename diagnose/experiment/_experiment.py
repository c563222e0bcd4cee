"""The next experiment: the command that best distinguishes the leading candidates.

Each candidate predicts its response to each command of a library. The difference of two predictions
counts only as far as the rival cannot compensate it: it may change its parameters, as far as the
given recordings allow, and its bias and initial state (to first order, by its Jacobian; for the
commands that lead, by fitting it to what the other predicts). What is left, squared over twice the
noise squared, is the log-likelihood by which the experiment would decide (Hunter and Reiner,
Technometrics 7 (1965) 307; Box and Hill, Technometrics 9 (1967) 57).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.diagnose.experiment._proposal import Proposal, Separation
from servosight.diagnose.experiment._rivals import PredictedExperiment, Rival, cost, refitted
from servosight.diagnose.selection import ModelSelection, Trial
from servosight.identify.design import predicted_experiment
from servosight.models.core import InputError, Recording
from servosight.models.excitation import CommandLimits, Design, Form, design

MOST_CANDIDATES = 4
FINALISTS = 5
REFITTED = 3
"""Five commands are judged by Jacobians; of these up to three by refitting the closest pair."""
DURATION_S = (6.0, 20.0)
"""An experiment is as long as the longest recording, within these."""
PLENTY = 1000.0
"""More log-likelihood than this decides no better."""

_LIBRARY: tuple[tuple[str, float, Form], ...] = (
    *(("triangle", share, Form(frequency_hz=f)) for share in (1.0, 0.4) for f in (0.3, 1.0, 2.5)),
    *(("sine", share, Form(frequency_hz=f)) for share in (1.0, 0.3) for f in (0.5, 3.0, 6.0)),
    *(("steps", share, Form()) for share in (1.0, 0.3)),
    *(("chirp", share, Form()) for share in (1.0, 0.3)),
    *(("multisine", share, Form()) for share in (1.0, 0.4)),
    *(("prbs", share, Form(dwell_s=clock)) for share in (1.0, 0.4) for clock in (0.08, 0.25)),
    ("standard", 1.0, Form()),
)
"""Shape, share of the angle limit, and form."""


@dataclass(frozen=True)
class Experiment:
    """A command with the candidates' responses, and how well it distinguishes each pair."""

    design: Design
    answers: tuple[PredictedExperiment, ...]
    separations: tuple[Separation, ...]

    @property
    def closest(self) -> Separation:
        """The pair that it distinguishes least."""
        return min(self.separations, key=lambda one: one.log_likelihood)

    def decided(self, tolerance_deg: float) -> int:
        """How many pairs it distinguishes."""
        return sum(one.decides(tolerance_deg) for one in self.separations)

    def made_sure(self, models: ModelSelection, noise_deg: float) -> Experiment:
        """The same with its closest pair refitted: beyond small changes a Jacobian promises more
        than comes true.
        """
        old = self.closest
        one, other = (next(a for a in self.answers if a.rival.name == name) for name in old.between)
        lefts = [refitted(a, b, models, noise_deg) for a, b in ((one, other), (other, one))]
        least, difference = min(lefts)
        new = replace(old, log_likelihood=least, difference_deg=difference)
        return replace(
            self, separations=tuple(new if each is old else each for each in self.separations)
        )


def propose(
    candidates: Sequence[Trial],
    models: ModelSelection,
    noise_deg: float,
    tolerance_deg: float,
    limits: CommandLimits | None = None,
) -> Proposal:
    """The command that best separates the first four of ``candidates``, best first, two at least.

    Differences below ``tolerance_deg`` decide nothing. ``limits`` are the recordings' own where
    they are not given; frames come as recorded. Raises InputError where no shape fits the limits.
    """
    if len(candidates) < 2:
        raise ValueError("a proposal needs two candidates at least")
    allowed = limits or recorded_limits(models.recordings)
    rivals = [Rival(trial, _name(trial, candidates)) for trial in candidates[:MOST_CANDIDATES]]
    like = models.recordings[0]
    experiments = [
        (
            made,
            tuple(
                one.predict(predicted_experiment(made.excitation, like=like), models)
                for one in rivals
            ),
        )
        for made in _designs(allowed)
    ]
    if not experiments:
        raise InputError(
            f"the next experiment: no shape fits {allowed.words}, expected room for one; allow a "
            f"longer duration"
        )
    scale = max(noise_deg, 1e-9)
    rough = sorted(experiments, key=lambda one: _rough_score(one[1], scale), reverse=True)
    judged = [
        Experiment(made, answers, _separations(answers, scale))
        for made, answers in rough[:FINALISTS]
    ]
    judged.sort(key=lambda one: _score(s.log_likelihood for s in one.separations), reverse=True)
    sure: list[Experiment] = []
    for one in judged[:REFITTED]:
        sure.append(one.made_sure(models, scale))
        if sure[-1].closest.decides(tolerance_deg):
            break
    best = max(sure, key=lambda one: (one.decided(tolerance_deg), one.closest.log_likelihood))
    return Proposal.of(best.design, allowed, best.separations, scale, tolerance_deg)


def recorded_limits(recordings: Sequence[Recording]) -> CommandLimits:
    """The range, rate and duration that the recordings' own commands have used."""
    each = [CommandLimits.of(r.command_time_s, r.command_deg) for r in recordings]
    low = min(one.centre_deg - one.angle_deg for one in each)
    high = max(one.centre_deg + one.angle_deg for one in each)
    rates = [one.rate_deg_s for one in each if one.rate_deg_s is not None]
    return CommandLimits(
        0.5 * (high - low),
        max(rates) if len(rates) == len(each) else None,
        float(np.clip(max(one.duration_s for one in each), *DURATION_S)),
        0.5 * (high + low),
        max(one.rows_hz for one in each),
    )


def _designs(limits: CommandLimits) -> Iterator[Design]:
    for shape, share, form in _LIBRARY:
        smaller = replace(limits, angle_deg=share * limits.angle_deg)
        try:
            yield design(shape, smaller, form)
        except InputError:  # too short, or too few rows, for this one
            continue


def _rough_score(answers: tuple[PredictedExperiment, ...], noise_deg: float) -> float:
    return _score(
        cost(rival.left_roughly(truth), noise_deg)
        for rival, truth in itertools.permutations(answers, 2)
    )


def _separations(
    answers: tuple[PredictedExperiment, ...], noise_deg: float
) -> tuple[Separation, ...]:
    """Each pair, whichever of the two is the truth."""
    found = []
    for one, other in itertools.combinations(answers, 2):
        left = min(
            (one.left(other, noise_deg), other.left(one, noise_deg)),
            key=lambda rest: cost(rest, noise_deg),
        )
        found.append(
            Separation(
                between=(one.rival.name, other.rival.name),
                log_likelihood=cost(left, noise_deg),
                difference_deg=float(np.quantile(np.abs(left), 0.99)),
            )
        )
    return tuple(found)


def _score(separations: Iterator[float]) -> float:
    """Every pair counts; one that is far apart does not compensate one that is close."""
    return float(sum(np.log1p(min(one, PLENTY)) for one in separations))


def _name(trial: Trial, candidates: Sequence[Trial]) -> str:
    """The effects that not all candidates share."""
    shared = set.intersection(*(set(one.effects) for one in candidates))
    return " + ".join(name for name in trial.effects if name not in shared) or "none of them"
