"""The search among whole sets of effects, where steps end far from the floor."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from servosight.diagnose.selection._steps import SearchEffort, Step, step_to
from servosight.diagnose.selection.search._backward import BackwardSearch
from servosight.diagnose.selection.search._beam import BeamSearch
from servosight.diagnose.selection.search._joint import JointFits
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import Key, Trial
from servosight.models.core import StageProgress


def searched_widely(
    steps: Sequence[Step], visited: Visited, effort: SearchEffort, progress: StageProgress
) -> list[Step]:
    """Steps to the best model of a rich model's reduction and a beam, or ``steps`` if none is.

    It is looked for among all models that were ever fitted: no removal or swap can end above the
    best model seen.
    """
    backward = BackwardSearch(visited.models, visited, effort, progress)
    if not backward.search_unloaded() and not visited.criterion.done(visited.ranked()[0].score):
        backward.search(steps[0].trial)
    BeamSearch(visited.models, visited, effort, progress).search()
    return _to_lower(steps, visited, _simplest(visited))


def ordinary_at_once(visited: Visited, effort: SearchEffort, progress: StageProgress) -> Trial:
    """The first ordinary effects fitted at once, with k held where it may be."""
    models = visited.models
    progress("ordinary effects together with k held", 0, 1)
    return JointFits(models, visited, effort, progress).together(
        models.unloaded() or models.first()
    )


def fitted_jointly(
    steps: Sequence[Step], visited: Visited, effort: SearchEffort, progress: StageProgress
) -> list[Step]:
    """Steps to what is left of the first ordinary effects fitted at once, if they explain the data.

    Else ``steps``. It costs less than one step: several effects that explain the data only together
    need not be found one after the other.
    """
    if visited.models.unloaded() is None:
        return list(steps)
    begun = ordinary_at_once(visited, effort, progress)
    if not visited.criterion.settled(begun.score):
        return list(steps)
    best = _what_is_left(begun, visited, effort, progress)
    return steps_to(steps, visited, best) if visited.criterion.done(best.score) else list(steps)


def completed(
    steps: Sequence[Step], visited: Visited, effort: SearchEffort, progress: StageProgress
) -> list[Step]:
    """The steps, or those to what is left of the last model with the ordinary effects it lacks.

    For an answer that a search came to when all that it may cost was spent. Far from the floor the
    joint fits that it began with ended in another minimum; from a better model they need not. At
    the floor nothing is lacking, and to leave out each effect in turn costs little.
    """
    criterion, last = visited.criterion, steps[-1].trial
    trial = last
    if criterion.wants_search(last.score) and last.effects:
        trial = JointFits(visited.models, visited, effort, progress).with_ordinary(last)
    lower = visited.penalised_error(trial) < visited.penalised_error(last)
    if not criterion.settled(trial.score) and not lower:
        return list(steps)
    return _to_lower(steps, visited, _what_is_left(trial, visited, effort, progress))


def _what_is_left(
    trial: Trial, visited: Visited, effort: SearchEffort, progress: StageProgress
) -> Trial:
    """The best model once each effect of ``trial`` was left out in turn."""
    BackwardSearch(visited.models, visited, effort, progress).reduce(trial)
    return _simplest(visited)


def _to_lower(steps: Sequence[Step], visited: Visited, best: Trial) -> list[Step]:
    """The steps, or those to ``best`` if that ranks better than the last one's model."""
    lower = visited.penalised_error(best) < visited.penalised_error(steps[-1].trial)
    return steps_to(steps, visited, best) if lower else list(steps)


def _simplest(visited: Visited) -> Trial:
    """The best model, with each special case of its effects tried, whatever was tried before."""
    seen: set[Key] = set()
    while (best := visited.best()).key not in seen:
        seen.add(best.key)
        for name in visited.removable(best):
            visited.special_cases(best, name)
    return best


def steps_to(steps: Sequence[Step], visited: Visited, best: Trial) -> list[Step]:
    """The first step and those to ``best``; ``steps`` where they end there, or no path leads there.

    A model that lacks effects of the first one cannot be reached by adding some.
    """
    first, last = steps[0].trial, steps[-1].trial
    if best is last or not set(first.effects) <= set(best.effects):
        return list(steps)
    path = visited.path(first, best)
    return [steps[0], *itertools.starmap(step_to, zip(path[1:], path, strict=False))]
