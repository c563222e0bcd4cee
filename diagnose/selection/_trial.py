"""One model tried on recordings: fitted on some samples, judged on others."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from servosight.diagnose.selection._screen import Screen
from servosight.identify.fit import (
    Fit,
    first_look,
    fit_effects,
    polish,
    search_effects,
    sketch_effects,
)
from servosight.identify.problem import Problem, linear_start
from servosight.identify.search import GaussNewton, Outcome, drive, half_squares
from servosight.models.core import CORE, Array, Mask, Recording
from servosight.models.effects import Effect

BLOCK_S = 1.0
HELD_OUT_EVERY = 3
OWN_GENERATIONS = 8
LEAST_GAIN = 0.2
"""No model's k is less than this share of the gain that the recordings show."""
TRIAL_BUDGET = 150
"""Simulations after which a fit is looked at; those that lead go on to the end."""


def training_masks(recording: Recording) -> list[Mask]:
    """Masks that are True for the samples to fit on: every third block of one second is held out.

    Which third is settled by the motion alone: the first mask is the one without whose held-out
    samples the training ones lose least of the range, so that a model is judged within what it has
    seen. The first block always trains: without it the initial state is anybody's guess.
    """
    block = np.floor((recording.time_s - recording.time_s[0]) / BLOCK_S).astype(int)
    masks = [block % HELD_OUT_EVERY != third for third in reversed(range(1, HELD_OUT_EVERY))]
    usable = [mask for mask in masks if mask.any() and not mask.all()] or masks[:1]
    return sorted(usable, key=functools.partial(_unseen, recording))


def _unseen(recording: Recording, mask: Mask) -> float:
    """How far angle, speed and acceleration go beyond those of the samples under the mask."""
    speed = np.gradient(recording.angle_deg, recording.time_s)
    away = recording.angle_deg - np.median(recording.angle_deg)
    motion = np.abs(np.stack([away, speed, np.gradient(speed, recording.time_s)]))
    largest = motion.max(axis=1)
    return float(np.sum(1.0 - motion[:, mask].max(axis=1) / np.maximum(largest, 1e-12)))


@dataclass(frozen=True)
class Judged:
    """What a recording says about a model: prediction, error, and which samples were held out."""

    recording: Recording
    predicted_deg: Array
    training: Mask

    @cached_property
    def error_deg(self) -> Array:
        """Measured minus predicted angle [deg], (samples,)."""
        return self.recording.angle_deg - self.predicted_deg


@dataclass(frozen=True)
class Trial:
    """A fitted set of effects with its errors. ``judged`` lists all recordings, fitted ones first.

    Held-out samples are the masked blocks, or the validation recordings where there are any.
    """

    effects: tuple[str, ...]
    fit: Fit
    judged: tuple[Judged, ...]

    @cached_property
    def train_rmse_deg(self) -> float:
        """Rms error of the samples that were fitted [deg]."""
        return _rms([one.error_deg[one.training] for one in self.judged])

    @cached_property
    def held_out_rmse_deg(self) -> float:
        """Rms error of the samples that the fit has not seen [deg]."""
        return _rms([one.error_deg[~one.training] for one in self.judged])

    @cached_property
    def mean_square(self) -> float:
        """Mean square error over all samples, seen and held out [deg^2]."""
        errors = np.concatenate([one.error_deg for one in self.judged])
        return float(np.mean(errors**2))

    @property
    def samples(self) -> int:
        """How many samples there are in all."""
        return sum(one.recording.time_s.size for one in self.judged)

    @property
    def parameters(self) -> int:
        """How many physical parameters the model has."""
        return self.fit.problem.physical


@dataclass(frozen=True)
class Laboratory:
    """Recordings to fit on, recordings to validate on, and the catalogue to choose from.

    ``notebook`` keeps the best trial of each set of effects that was tried, ``wholes`` their fits
    to all samples, ``screens`` what was screened behind each fit. ``third`` says which of the
    thirds that may be held out is, best first.
    """

    recordings: tuple[Recording, ...]
    validate: tuple[Recording, ...]
    catalogue: Mapping[str, Effect]
    third: int = 0
    notebook: dict[tuple[str, ...], Trial] = field(default_factory=dict, compare=False)
    wholes: dict[tuple[str, ...], Trial] = field(default_factory=dict, compare=False)
    screens: dict[tuple[tuple[str, ...], float], Screen] = field(
        default_factory=dict, compare=False
    )

    def anew(self, **changes: Any) -> Laboratory:
        """The same with changes, and nothing in its books."""
        return replace(self, notebook={}, wholes={}, screens={}, **changes)

    @cached_property
    def masks(self) -> tuple[Mask, ...]:
        """Samples to fit on; all of them where others validate."""
        if self.validate:
            return tuple(np.ones(r.time_s.size, dtype=bool) for r in self.recordings)
        choices = [training_masks(recording) for recording in self.recordings]
        return tuple(masks[min(self.third, len(masks) - 1)] for masks in choices)

    @cached_property
    def k_bounds(self) -> tuple[float, float]:
        """Bounds of k for models with effects.

        A weight that falls over, or detents as steep, can cancel the loop's stiffness: k and T then
        go towards zero together, the gain stays, and what is left bends as no servo does.
        """
        fit = self.linear().fit
        k = fit.problem.values(fit.outcome.point)["k"]
        moved = np.sqrt(sum(np.var(recording.angle_deg) for recording in self.recordings))
        asked = np.sqrt(sum(np.var(recording.command_deg) for recording in self.recordings))
        least = LEAST_GAIN * min(abs(k), float(moved / max(asked, 1e-12)))
        _, most = CORE[0].search_bounds
        return (least, most) if k >= 0.0 else (-most, -least)

    def problem(self, effects: Sequence[str]) -> Problem:
        """The fit of some effects to the training samples."""
        return self._problem(effects, self.masks)

    def _problem(self, effects: Sequence[str], masks: Sequence[Mask] | None) -> Problem:
        ordered = [name for name in self.catalogue if name in set(effects)]
        bounds = self.k_bounds if ordered else None
        return Problem.of(self.recordings, self.catalogue, ordered, masks, bounds)

    def linear(self) -> Trial:
        """The linear model: where every ladder stands."""
        if () not in self.notebook:
            problem = self.problem(())
            self.judge(polish(problem, [linear_start(problem)]))
        return self.notebook[()]

    def candidates(self, base: Trial) -> list[str]:
        """The effects that ``base`` lacks, and that are no special case of one that it has."""
        covered = {name for own in base.effects for name in self.catalogue[own].contains}
        return [n for n in self.catalogue if n not in base.effects and n not in covered]

    def with_effect(self, base: Trial, name: str) -> Problem:
        """The fit of ``base`` and one effect more, which takes the place of what it contains."""
        kept = [own for own in base.effects if own not in self.catalogue[name].contains]
        return self.problem((*kept, name))

    def sketched(self, base: Trial, name: str) -> Trial:
        """``base`` with one effect more, fitted roughly: enough to see where it leads.

        It is judged on the recordings that it was fitted to alone.
        """
        fit = sketch_effects(self.with_effect(base, name), base.fit)
        return Trial(fit.problem.effects, fit, self._seen(fit))

    def extended(self, base: Trial, name: str, sketch: Trial | None = None) -> Trial:
        """``base`` with one effect more, all parameters fitted anew; a sketch is one start more."""
        fit = None if sketch is None else sketch.fit
        return self.judge(fit_effects(self.with_effect(base, name), base.fit, fit, TRIAL_BUDGET))

    def finished(self, trial: Trial) -> Trial:
        """A trial whose budget was spent, fitted to the end."""
        if not trial.fit.spent:
            return trial
        return self.judge(polish(trial.fit.problem, [trial.fit.outcome.point]))

    def searched(self, base: Trial, trial: Trial, name: str) -> Trial:
        """``trial``, which adds an effect to ``base``, or what many more starts find if better."""
        fit = search_effects(self.with_effect(base, name), base.fit)
        return self.judge(fit) if fit.outcome.cost < trial.fit.outcome.cost else trial

    def screen(self, base: Trial) -> Screen:
        """What each candidate behind ``base`` would change in its error, to first order."""
        fit = base.fit
        seen = (base.effects, fit.outcome.cost)
        if seen not in self.screens:
            owners: list[str] = []
            changes = []
            for name in self.candidates(base):
                problem = self.with_effect(base, name)
                changes.append(first_look(problem, fit))
                owners += [name] * len(changes[-1])
            joined = np.concatenate([np.empty((0, fit.residual.size)), *changes])
            self.screens[seen] = Screen.of(tuple(owners), joined, fit.residual, fit.jacobian)
        return self.screens[seen]

    def without(self, base: Trial, name: str) -> Trial:
        """``base`` less one effect, all else as it stood: not fitted."""
        problem = self.problem([own for own in base.effects if own != name])
        known = {
            (c.name, c.recording): x
            for c, x in zip(base.fit.problem.coordinates, base.fit.outcome.point, strict=True)
        }
        point = np.array([known[(c.name, c.recording)] for c in problem.coordinates])
        cost = float(half_squares(problem.residuals(point[None, :]))[0])
        fit = Fit(problem, Outcome(point, cost, 1, "not fitted", np.array([cost]), point[None, :]))
        return Trial(problem.effects, fit, self._seen(fit))

    def reduced(self, base: Trial, without: str) -> Trial:
        """``base`` with one effect fewer, fitted anew from where the rest stood."""
        start = self.without(base, without).fit
        return self.judge(polish(start.problem, [start.outcome.point]))

    def swapped(self, base: Trial, name: str, other: str) -> Trial:
        """``base`` with one effect in another's place, fitted anew from where the rest stood."""
        left = self.without(base, name)
        return self.judge(fit_effects(self.with_effect(left, other), left.fit))

    def whole(self, trial: Trial) -> Trial:
        """A model fitted anew to all samples, the held-out ones among them."""
        if self.validate:
            return trial
        known = self.wholes.get(trial.effects)
        if known is None:
            problem = self._problem(trial.effects, None)
            fit = polish(problem, [trial.fit.outcome.point])
            known = self.wholes[trial.effects] = Trial(trial.effects, fit, self._seen(fit))
        return known

    def judge(self, fit: Fit) -> Trial:
        """Simulate every recording at the fitted point."""
        unseen = [
            Judged(
                recording,
                carried_over(recording, self.catalogue, fit.problem.effects, fit),
                np.zeros(recording.time_s.size, dtype=bool),
            )
            for recording in self.validate
        ]
        trial = Trial(fit.problem.effects, fit, (*self._seen(fit), *unseen))
        known = self.notebook.get(trial.effects)
        if known is None or trial.fit.outcome.cost < known.fit.outcome.cost:
            self.notebook[trial.effects] = trial
        return trial

    def _seen(self, fit: Fit) -> tuple[Judged, ...]:
        angles = fit.problem.predict(fit.outcome.point)
        return tuple(
            Judged(recording, predicted[0], mask)
            for recording, predicted, mask in zip(self.recordings, angles, self.masks, strict=True)
        )


def carried_over(
    recording: Recording, catalogue: Mapping[str, Effect], effects: Sequence[str], fit: Fit
) -> Array:
    """Prediction [deg] for another recording with the physical parameters held fixed.

    Only what each recording has for itself (bias, initial angle and speed) is found on it.
    """
    values = fit.outcome.point[: fit.problem.physical]
    return predict_fixed(recording, Problem.of([recording], catalogue, effects), values)


def predict_fixed(recording: Recording, problem: Problem, physical: Array) -> Array:
    """Prediction [deg] at fixed physical coordinates, with the recording's own numbers fitted."""
    low, high = problem.bounds
    fixed = problem.physical
    values = problem.values(np.concatenate([physical, np.zeros(3)]))
    own = np.array(
        [
            float(np.median(recording.angle_deg) - values["k"] * np.median(recording.command_deg)),
            float(recording.angle_deg[:3].mean()),
            0.0,
        ]
    )

    def residuals(points: Array) -> Array:
        return problem.residuals(np.hstack([np.tile(physical, (len(points), 1)), points]))

    descent = GaussNewton(own, low[fixed:], high[fixed:], np.ones(3), generations=OWN_GENERATIONS)
    outcome = drive(descent, residuals, 600)
    return np.asarray(problem.predict(np.concatenate([physical, outcome.point]))[0][0])


def _rms(parts: Sequence[Array]) -> float:
    joined = np.concatenate(parts)
    if joined.size == 0:
        return 0.0
    return float(np.sqrt(np.mean(joined**2)))
