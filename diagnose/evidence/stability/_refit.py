"""A model fitted to parts of its data: one Gauss-Newton step from its fit to the whole of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.diagnose.evidence.stability._resamples import Resample
from servosight.diagnose.residuals import TEST, VALIDATION, Judged
from servosight.diagnose.selection import ModelSelection, Score, Trial, own_point
from servosight.identify.problem import Problem, coordinate_scale, difference_quotient
from servosight.models.core import Array, Mask

SHARES = (1.0, 0.5, 0.25)
"""The step is also tried shorter; none is taken where it does not lower the cost."""
_RIDGE = 1e-6
"""A direction that the data hardly determine is not followed: singular values below this share."""


def resampled_scores(
    models: ModelSelection, trial: Trial, parts: Sequence[Resample]
) -> list[Score]:
    """The score of a model on each resample, its parameters fitted to that one's fitted samples.

    Simulated, not extrapolated: only how far the parameters move is taken from the Jacobian. For
    recordings that only validate, bias and initial state move as well, to first order.
    """
    points = _points(trial, parts)
    fitted = trial.fit.problem.predict(points)
    carried = [
        _carried(models, trial, one, points, [part[number] for part in parts])
        for number, one in enumerate(trial.judged)
        if number >= len(fitted)
    ]
    scores = []
    for place, part in enumerate(parts):
        predicted = [angles[place] for angles in (*fitted, *carried)]
        scores.append(_score(trial, predicted, part))
    return scores


def _points(trial: Trial, parts: Sequence[Resample]) -> Array:
    """The search point for each resample, (resamples, coordinates)."""
    fit = trial.fit
    problem, point = fit.problem, fit.outcome.point
    low, high = problem.bounds
    scale = coordinate_scale(problem, point) + np.abs(point)
    kept = [
        np.concatenate([m[one] for m, one in zip(part, problem.masks, strict=False)])
        for part in parts
    ]
    candidates = []
    for own in kept:
        step = _step(fit.jacobian[own] * scale, fit.residual[own]) * scale
        candidates += [np.clip(point + share * step, low, high) for share in SHARES]
    residuals = problem.residuals(np.array(candidates))
    found = []
    for place, own in enumerate(kept):
        rows = slice(place * len(SHARES), (place + 1) * len(SHARES))
        costs = np.sum(residuals[rows][:, own] ** 2, axis=1)
        best = int(np.argmin(costs))
        better = costs[best] < float(np.sum(fit.residual[own] ** 2))
        found.append(candidates[rows][best] if better else point)
    return np.array(found)


def _step(jacobian: Array, residual: Array) -> Array:
    return np.asarray(-np.linalg.lstsq(jacobian, residual, rcond=_RIDGE)[0])


def _carried(
    models: ModelSelection, trial: Trial, one: Judged, points: Array, kept: Sequence[Mask]
) -> Array:
    """Predictions (resamples, samples) of a recording that is not fitted, physical values given."""
    count = trial.fit.problem.physical
    scored = one.uses == VALIDATION
    problem = Problem.of([one.recording], models.catalogue, trial.effects, [scored])
    own = own_point(one.recording, problem, trial.fit.outcome.point[:count])
    slopes = difference_quotient(problem, own, coordinate_scale(problem, own))[:, count:]
    moved = np.hstack([points[:, :count], np.tile(own[count:], (len(points), 1))])
    residuals = problem.residuals(moved)
    steps = [
        _step(slopes[part[scored]], residual[part[scored]])
        for residual, part in zip(residuals, kept, strict=True)
    ]
    moved[:, count:] += np.array(steps)
    return np.asarray(problem.predict(np.clip(moved, *problem.bounds))[0])


def _score(trial: Trial, predicted: Sequence[Array], part: Resample) -> Score:
    """The score on the samples that are kept; the others are set apart as test samples are."""
    judged = tuple(
        replace(one, predicted_deg=angle, uses=np.where(kept, one.uses, np.int8(TEST)))
        for one, angle, kept in zip(trial.judged, predicted, part, strict=True)
    )
    return replace(trial, judged=judged).score
