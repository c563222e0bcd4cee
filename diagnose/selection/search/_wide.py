"""The search among whole sets of effects, where steps end far from the floor."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from servosight.diagnose.selection._steps import SearchEffort, Step, step_to
from servosight.diagnose.selection.search._backward import BackwardSearch
from servosight.diagnose.selection.search._beam import BeamSearch
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import Trial
from servosight.models.core import StageProgress


def searched_widely(
    steps: Sequence[Step], visited: Visited, effort: SearchEffort, progress: StageProgress
) -> list[Step]:
    """Steps to the best model of a rich model's reduction and a beam, or ``steps`` if none is.

    It is looked for among all models that were ever fitted: no removal or swap can end above the
    best model seen.
    """
    first, last = steps[0].trial, steps[-1].trial
    backward = BackwardSearch(visited.models, visited, effort, progress)
    # At several gains the data determine k, but fits that begin with a wrong one may end there.
    if not backward.search_unloaded() or not visited.models.at_one_gain:
        backward.search(first)
    BeamSearch(visited.models, visited, effort, progress).search()
    best = visited.best()
    cheaper = visited.price(best) < visited.price(last)
    return steps_to(steps, visited, best) if cheaper else list(steps)


def steps_to(steps: Sequence[Step], visited: Visited, best: Trial) -> list[Step]:
    """The first step and those to ``best``; ``steps`` where they end there, or no path leads there.

    A model that lacks effects of the first one cannot be reached by adding some.
    """
    first, last = steps[0].trial, steps[-1].trial
    if best is last or not set(first.effects) <= set(best.effects):
        return list(steps)
    path = visited.path(first, best)
    return [steps[0], *itertools.starmap(step_to, zip(path[1:], path, strict=False))]
