"""Rival models of the same recordings: what each predicts, and what of the other it can take up."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from servosight.diagnose.selection import ModelSelection, Trial
from servosight.identify.fit import polish
from servosight.identify.problem import (
    Problem,
    coordinate_scale,
    difference_quotient,
    projected_out,
)
from servosight.models.core import Array, Recording

REFIT_BUDGET = 120
"""Evaluations of a refit: it starts next to its end."""


@dataclass(frozen=True)
class Rival:
    """A fitted model, and how far the given recordings allow its parameters to change."""

    trial: Trial
    name: str

    @cached_property
    def physical(self) -> Array:
        """Its shared coordinates."""
        return self.trial.fit.outcome.point[: self.trial.fit.problem.physical]

    @cached_property
    def recorded(self) -> tuple[Array, Array]:
        """Jacobian of the recordings' own coordinates, and of the shared ones without these."""
        jacobian, count = self.trial.fit.jacobian, self.trial.fit.problem.physical
        own = jacobian[:, count:]
        return own, projected_out(jacobian[:, :count], own)

    def predict(self, recording: Recording, models: ModelSelection) -> PredictedExperiment:
        """The candidate on an experiment, at rest where its first row puts it."""
        fit = self.trial.fit
        held = fit.problem.held
        problem = Problem.of([recording], models.catalogue, self.trial.effects, held=held)
        own = {
            coordinate.name: float(x)
            for coordinate, x in zip(fit.problem.coordinates, fit.outcome.point, strict=True)
            if coordinate.recording == 0
        }
        k = fit.problem.values(fit.outcome.point)["k"]
        own["initial_angle"] = k * float(recording.command_deg[0]) + own["bias"]
        own["initial_speed"] = 0.0
        fresh = [own[coordinate.name] for coordinate in problem.coordinates[problem.physical :]]
        return PredictedExperiment(self, problem, np.concatenate([self.physical, fresh]))


@dataclass(frozen=True)
class PredictedExperiment:
    """A candidate's response to one experiment."""

    rival: Rival
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

    def left_roughly(self, truth: PredictedExperiment) -> Array:
        """What this one cannot take up of another's answer, by the linear core alone."""
        difference = truth.angle_deg - self.angle_deg
        return projected_out(difference[:, None], self.smooth)[:, 0]

    def left(self, truth: PredictedExperiment, noise_deg: float) -> Array:
        """What this one cannot take up when it is fitted to the recordings and the experiment.

        Parameters may move by about themselves: beyond, the Jacobian says nothing.
        """
        count = self.problem.physical
        own, shared = self.rival.recorded
        before = self.rival.trial.fit.residual - truth.rival.trial.fit.residual
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


def refitted(
    rival: PredictedExperiment, truth: PredictedExperiment, models: ModelSelection, noise_deg: float
) -> tuple[float, float]:
    """Log-likelihood and largest difference [deg] left when ``rival`` is fitted to ``truth``."""
    fit = truth.rival.trial.fit
    given = [
        replace(recording, angle_deg=angles[0])
        for recording, angles in zip(
            models.recordings, fit.problem.predict(fit.outcome.point), strict=True
        )
    ]
    (fresh,) = rival.problem.recordings
    masks = [*models.split.masks, np.ones(fresh.time_s.size, dtype=bool)]
    problem = Problem.of(
        [*given, replace(fresh, angle_deg=truth.angle_deg)],
        models.catalogue,
        rival.rival.trial.effects,
        masks,
        held=rival.problem.held,
    )
    own = rival.point[rival.problem.physical :]
    start = np.concatenate([rival.rival.trial.fit.outcome.point, own])
    joint = polish(problem, [start], REFIT_BUDGET)
    left = joint.residual[-fresh.time_s.size :]
    return joint.outcome.cost / noise_deg**2, float(np.quantile(np.abs(left), 0.99))


def cost(difference: Array, noise_deg: float) -> float:
    """Log-likelihood that a difference (samples,) is worth."""
    return float(np.sum(difference**2) / (2.0 * noise_deg**2))
