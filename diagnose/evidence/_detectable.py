"""From which size on recordings would have shown each effect, by what the selection asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from servosight.diagnose.residuals import turning_points
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    SelectionPolicy,
    Trial,
)
from servosight.identify.fit import Detectable, Fit, fitted_solution, size_shown
from servosight.identify.problem import Problem, offered, thinned, usable_views
from servosight.models.core import Array, Recording, Table, one_or_more
from servosight.models.effects import Effect, covered


def detectable(
    models: ModelSelection, last: Trial, criterion: AcceptanceCriterion
) -> tuple[Detectable, ...]:
    """For each effect that ``last`` lacks, the smallest size that the fitted data would show.

    Each is added to ``last``: what the parameters of its effects can produce as well does not show.
    Where ``last`` is above the floor, so much of the error must go that the effect is accepted, as
    if what remains were this effect alone: with others missing it needs more.
    """
    names = models.candidates(last)
    still = _never_reverses([one.predicted_deg for one in last.judged])
    above = max(last.score.train_rmse_deg**2 - criterion.floor_deg**2, 0.0)
    share_deg = float(np.sqrt(criterion.policy.min_share * above))
    found = []
    for name in names:
        problem = models.with_effect(last, name)
        least = max(_least_deg(criterion, problem, len(names)), share_deg)
        found.append(size_shown(name, problem, last.fit, least, still))
    return tuple(found)


def with_detectable(
    fit: Fit, recordings: Recording | Sequence[Recording], catalogue: Mapping[str, Effect]
) -> Fit:
    """``fit`` with the smallest size of each effect that it lacks that its recordings would show.

    ``recordings`` are those that it was fitted to, ``catalogue`` the effects that are looked at.
    """
    scored, _ = thinned(usable_views(one_or_more(recordings))[0])
    base = fitted_solution(scored, catalogue, fit.effects, fit.parameters, fit.own, fit.fixed)
    tolerance = float(np.sqrt(max(fit.floor_deg**2 - fit.noise_deg**2, 0.0)))
    criterion = AcceptanceCriterion(fit.floor_deg, tolerance, SelectionPolicy())
    there = covered(fit.effects, catalogue)
    names = [name for name in offered(catalogue, scored) if name not in there]
    still = _never_reverses([angles[0] for angles in base.problem.predict(base.outcome.point)])
    found = []
    for name in names:
        kept = [own for own in fit.effects if own not in catalogue[name].contains]
        ordered = [one for one in catalogue if one in (*kept, name)]
        problem = Problem.of(scored, catalogue, ordered, held=base.problem.held)
        least = _least_deg(criterion, problem, len(names))
        found.append(size_shown(name, problem, base, least, still))
    return replace(fit, detectable=Table(found))


def _never_reverses(angles_deg: Sequence[Array]) -> bool:
    return all(turning_points(angle_deg).size == 0 for angle_deg in angles_deg)


def _least_deg(criterion: AcceptanceCriterion, problem: Problem, tried: int) -> float:
    """The rms change [deg] with which an effect is accepted on a model at the floor."""
    policy = criterion.policy
    scored = max(sum(int(mask.sum()) for mask in problem.masks), 1)
    needed = policy.min_evidence + np.log(max(tried, 1)) + 0.5 * problem.physical * np.log(scored)
    evident = np.expm1(min(2.0 * needed / scored, 50.0))
    gained = 1.0 / (1.0 - policy.min_gain) ** 2 - 1.0
    return float(criterion.floor_deg * np.sqrt(max(policy.min_removed**2, evident, gained)))
