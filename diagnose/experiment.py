"""The next experiment: the command that best tells the leading candidates apart.

Each candidate predicts its answer to each command of a library. The difference of two predictions
counts only as far as the rival cannot take it up: it may move its parameters, bound by the
recordings at hand, and its bias and initial state anew (to first order, by its Jacobian). What is
left, squared over twice the noise squared, is the log-likelihood by which the experiment would
decide (Box and Hill, Technometrics 9 (1967) 57; Hunter and Reiner, Technometrics 7 (1965) 307).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from servosight.diagnose.evidence import TIE
from servosight.diagnose.trial import Laboratory, Trial
from servosight.identify.fit import coordinate_scale, difference_quotient
from servosight.identify.information import projected_out
from servosight.identify.problem import Problem
from servosight.identify.rehearsal import rehearsal
from servosight.models.design import Design, Form, Limits, design
from servosight.models.errors import InputError
from servosight.models.excitation import Excitation
from servosight.models.recording import Recording

Array = NDArray[np.float64]

MOST_CANDIDATES = 4
FINALISTS = 5
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
class Separation:
    """What an experiment tells of a pair: log-likelihood, and the largest difference left [deg]."""

    first: str
    second: str
    log_likelihood: float
    difference_deg: float

    def to_json(self) -> dict[str, Any]:
        """As a table."""
        return {
            "between": [self.first, self.second],
            "log_likelihood": self.log_likelihood,
            "difference_deg": self.difference_deg,
        }


@dataclass(frozen=True)
class Proposal:
    """The experiment to run next, and what it would tell."""

    design: Design
    limits: Limits
    separations: tuple[Separation, ...]
    noise_deg: float

    @property
    def excitation(self) -> Excitation:
        """The command's rows; ``save`` writes them."""
        return self.design.excitation

    @property
    def decides(self) -> bool:
        """True where every pair would be told apart."""
        return all(one.log_likelihood >= TIE for one in self.separations)

    @property
    def sentence(self) -> str:
        """What to run, and by how much the closest pair would then differ."""
        closest = min(self.separations, key=lambda one: one.log_likelihood)
        pair = f"{closest.first} and {closest.second}"
        size = (
            f"{closest.difference_deg:.2g} deg, "
            f"{closest.difference_deg / self.noise_deg:.2g} times the noise"
        )
        if not self.decides:
            return (
                f"No command within {self.limits.words} tells {pair} apart for sure; the best is "
                f"the {self.design.words}, where they differ by up to {size}: allow a larger or "
                f"faster command, or see `servosight effects` for a test by hand."
            )
        return (
            f"Run the {self.design.words}: {pair} would then differ by up to {size}; diagnose both "
            f"recordings together."
        )

    def to_json(self) -> dict[str, Any]:
        """The command in words, and every pair."""
        return {
            "command": self.design.words,
            "notes": list(self.design.notes),
            "decides": self.decides,
            "separations": [one.to_json() for one in self.separations],
        }


@dataclass(frozen=True)
class Candidate:
    """A fitted model, and what the recordings at hand allow it to become."""

    trial: Trial
    name: str

    @cached_property
    def physical(self) -> Array:
        """Its shared coordinates."""
        return self.trial.fit.outcome.point[: self.trial.fit.problem.physical]

    @cached_property
    def residuals(self) -> Array:
        """On the samples it was fitted to, (scored,)."""
        fit = self.trial.fit
        return np.asarray(fit.problem.residuals(fit.outcome.point[None, :])[0])

    @cached_property
    def recorded(self) -> tuple[Array, Array]:
        """Jacobian of the recordings' own coordinates, and of the shared ones without these."""
        jacobian, count = self.trial.fit.jacobian, self.trial.fit.problem.physical
        own = jacobian[:, count:]
        return own, projected_out(jacobian[:, :count], own)

    def rehearse(self, recording: Recording, laboratory: Laboratory) -> Rehearsed:
        """The candidate on an experiment, at rest where its first row puts it."""
        fit = self.trial.fit
        problem = Problem.of([recording], laboratory.catalogue, self.trial.effects)
        own = {
            coordinate.name: float(x)
            for coordinate, x in zip(fit.problem.coordinates, fit.outcome.point, strict=True)
            if coordinate.recording == 0
        }
        k = fit.problem.values(fit.outcome.point)["k"]
        own["initial_angle"] = k * float(recording.command_deg[0]) + own["bias"]
        own["initial_speed"] = 0.0
        fresh = [own[coordinate.name] for coordinate in problem.coordinates[problem.physical :]]
        return Rehearsed(self, problem, np.concatenate([self.physical, fresh]))


@dataclass(frozen=True)
class Rehearsed:
    """A candidate's answer to one experiment."""

    candidate: Candidate
    problem: Problem
    point: Array

    @cached_property
    def angle_deg(self) -> Array:
        """Prediction, (samples,)."""
        return np.asarray(self.problem.predict(self.point)[0][0])

    @cached_property
    def jacobian(self) -> Array:
        """Of the residuals, (samples, coordinates)."""
        scale = coordinate_scale(self.problem, self.point)
        return difference_quotient(self.problem, self.point, scale)

    @cached_property
    def smooth(self) -> Array:
        """What stands in for the Jacobian of bias, k, T, xi and delay, (samples, 4)."""
        speed = np.gradient(self.angle_deg)
        ones = np.ones_like(speed)
        return np.stack([ones, self.angle_deg, speed, np.gradient(speed)], axis=1)

    def left_roughly(self, truth: Rehearsed) -> Array:
        """What this one cannot take up of another's answer, by the linear core alone."""
        difference = truth.angle_deg - self.angle_deg
        return projected_out(difference[:, None], self.smooth)[:, 0]

    def left(self, truth: Rehearsed, noise_deg: float) -> Array:
        """What this one cannot take up when it is fitted to the recordings and the experiment.

        Parameters may move by about themselves: beyond, the Jacobian says nothing.
        """
        count = self.problem.physical
        own, shared = self.candidate.recorded
        before = self.candidate.residuals - truth.candidate.residuals
        before = projected_out(before[:, None], own)[:, 0]
        after = truth.angle_deg - self.angle_deg
        anew = self.jacobian[:, count:]
        after = projected_out(after[:, None], anew)[:, 0]
        fresh = projected_out(self.jacobian[:, :count], anew)
        reach = coordinate_scale(self.problem, self.point) + np.abs(self.point)
        prior = np.diag(noise_deg / reach[:count])
        stacked = np.vstack([shared, fresh, prior])
        target = np.concatenate([before, after, np.zeros(count)])
        move = np.linalg.lstsq(stacked, -target, rcond=None)[0]
        return np.asarray(after + fresh @ move)


def propose(
    candidates: Sequence[Trial],
    laboratory: Laboratory,
    noise_deg: float,
    limits: Limits | None = None,
) -> Proposal:
    """The command that best separates the first four of ``candidates``, best first, two at least.

    ``limits`` are the recordings' own where they are not given; frames come as recorded. Raises
    InputError where no shape fits the limits.
    """
    if len(candidates) < 2:
        raise ValueError("a proposal needs two candidates at least")
    allowed = limits or recorded_limits(laboratory.recordings)
    rivals = [Candidate(trial, _name(trial, candidates)) for trial in candidates[:MOST_CANDIDATES]]
    like = laboratory.recordings[0]
    experiments = [
        (
            made,
            [rival.rehearse(rehearsal(made.excitation, like=like), laboratory) for rival in rivals],
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
    judged = [(made, _separations(answers, scale)) for made, answers in rough[:FINALISTS]]
    best, separations = max(judged, key=lambda one: _score(s.log_likelihood for s in one[1]))
    return Proposal(best, allowed, separations, scale)


def recorded_limits(recordings: Sequence[Recording]) -> Limits:
    """The range, rate and duration that the recordings' own commands have used."""
    each = [Limits.of(r.command_time_s, r.command_deg) for r in recordings]
    low = min(one.centre_deg - one.angle_deg for one in each)
    high = max(one.centre_deg + one.angle_deg for one in each)
    rates = [one.rate_deg_s for one in each if one.rate_deg_s is not None]
    return Limits(
        0.5 * (high - low),
        max(rates) if len(rates) == len(each) else None,
        float(np.clip(max(one.duration_s for one in each), *DURATION_S)),
        0.5 * (high + low),
        max(one.rows_hz for one in each),
    )


def _designs(limits: Limits) -> Iterator[Design]:
    for shape, share, form in _LIBRARY:
        smaller = replace(limits, angle_deg=share * limits.angle_deg)
        try:
            yield design(shape, smaller, form)
        except InputError:  # too short, or too few rows, for this one
            continue


def _rough_score(answers: Sequence[Rehearsed], noise_deg: float) -> float:
    return _score(
        _cost(rival.left_roughly(truth), noise_deg)
        for rival, truth in itertools.permutations(answers, 2)
    )


def _separations(answers: Sequence[Rehearsed], noise_deg: float) -> tuple[Separation, ...]:
    """Each pair, whichever of the two is the truth."""
    found = []
    for one, other in itertools.combinations(answers, 2):
        left = min(
            (one.left(other, noise_deg), other.left(one, noise_deg)),
            key=lambda rest: _cost(rest, noise_deg),
        )
        found.append(
            Separation(
                one.candidate.name,
                other.candidate.name,
                _cost(left, noise_deg),
                float(np.quantile(np.abs(left), 0.99)),
            )
        )
    return tuple(found)


def _score(separations: Iterator[float]) -> float:
    """Every pair counts; one that is far apart makes up for none that is close."""
    return float(sum(np.log1p(min(one, PLENTY)) for one in separations))


def _cost(difference: Array, noise_deg: float) -> float:
    return float(np.sum(difference**2) / (2.0 * noise_deg**2))


def _name(trial: Trial, candidates: Sequence[Trial]) -> str:
    """The effects that not all candidates share."""
    shared = set.intersection(*(set(one.effects) for one in candidates))
    return " + ".join(name for name in trial.effects if name not in shared) or "none of them"
