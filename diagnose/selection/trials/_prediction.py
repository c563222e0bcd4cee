"""Predictions of a fitted model: of the recordings that it was fitted to, and of others, each of
which keeps what it has for itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from servosight.diagnose.residuals import TEST, VALIDATION, Judged
from servosight.diagnose.selection._split import Split
from servosight.diagnose.selection.trials._trial import Trial
from servosight.identify.fit import OwnValues, Solution, own_values
from servosight.identify.problem import Problem, own_starts
from servosight.identify.search import DescentOptions, LevenbergMarquardt, drive, half_squares
from servosight.models.core import Array, Mask, Recording
from servosight.models.effects import Effect

OWN_DESCENT = DescentOptions(generations=8)
OWN_BUDGET = 600


def seen(fit: Solution, split: Split) -> tuple[Judged, ...]:
    """The fitted recordings, simulated at the fitted point."""
    angles = fit.problem.predict(fit.outcome.point)
    return tuple(
        Judged(recording, predicted[0], uses)
        for recording, predicted, uses in zip(split.recordings, angles, split.uses, strict=True)
    )


def carried(fit: Solution, split: Split, catalogue: Mapping[str, Effect]) -> tuple[Judged, ...]:
    """The recordings that only validate, their own numbers found on the validation samples."""
    return tuple(
        Judged(
            one,
            carried_over(one, catalogue, fit.problem.effects, fit, uses == VALIDATION),
            uses,
            beyond,
        )
        for one, uses, beyond in zip(
            split.carried, split.carried_uses, split.carried_beyond, strict=True
        )
    )


def tested_alone(
    fit: Solution, split: Split, catalogue: Mapping[str, Effect]
) -> tuple[Judged, ...]:
    """The recordings that only test, their own numbers found on all of them."""
    return tuple(
        Judged(
            one,
            carried_over(one, catalogue, fit.problem.effects, fit),
            np.full(one.time_s.size, TEST, np.int8),
        )
        for one in split.tested
    )


def carried_over(
    recording: Recording,
    catalogue: Mapping[str, Effect],
    effects: Sequence[str],
    fit: Solution,
    mask: Mask | None = None,
) -> Array:
    """Prediction [deg] for another recording with the physical parameters fixed, (samples,).

    Only what each recording has for itself (bias, initial angle and speed) is found on it, on the
    samples under ``mask``, or on all of them.
    """
    values = fit.outcome.point[: fit.problem.physical]
    masks = None if mask is None else [mask]
    return predict_fixed(recording, Problem.of([recording], catalogue, effects, masks), values)


def predict_fixed(recording: Recording, problem: Problem, physical: Array) -> Array:
    """Prediction [deg] at fixed physical coordinates, with the recording's own numbers fitted."""
    return np.asarray(problem.predict(own_point(recording, problem, physical))[0][0])


def own_point(recording: Recording, problem: Problem, physical: Array) -> Array:
    """The problem's point with ``physical`` coordinates and the own ones fitted behind them.

    Own are bias [deg], initial angle [deg] and initial speed [deg/s]. The fit begins at the best of
    some guesses: from one that is off by degrees it can end at a motion that there never was.
    """
    low, high = problem.bounds
    fixed = problem.physical
    values = problem.values(np.concatenate([physical, np.zeros(3)]))
    (mask,) = problem.masks
    starts = own_starts(recording, values["k"], mask)

    def residuals(points: Array) -> Array:
        return problem.residuals(np.hstack([np.tile(physical, (len(points), 1)), points]))

    own = starts[int(np.argmin(half_squares(residuals(starts))))]
    bounds = low[fixed:], high[fixed:]
    descent = LevenbergMarquardt(own, *bounds, np.ones(3), OWN_DESCENT)
    return np.concatenate([physical, drive(descent, residuals, OWN_BUDGET).point])


def own_of(trial: Trial, split: Split, catalogue: Mapping[str, Effect]) -> tuple[OwnValues, ...]:
    """What each recording has for itself: those fitted, those carried over, those for the test."""
    fit = trial.fit
    physical = fit.outcome.point[: fit.problem.physical]
    found = list(own_values(fit.problem, fit.outcome.point))
    masks = [use == VALIDATION for use in split.carried_uses]
    masks += [np.ones(one.time_s.size, dtype=bool) for one in split.tested]
    for recording, mask in zip((*split.carried, *split.tested), masks, strict=True):
        problem = Problem.of([recording], catalogue, trial.effects, [mask])
        found += own_values(problem, own_point(recording, problem, physical))
    return tuple(found)
